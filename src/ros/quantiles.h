// Median and 90 % quantile.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace gms_ransac {

template <typename Number>
struct Quantiles {
  Number median = 0, p90 = 0;
};

/// Zeros if there are no values.
template <typename Number>
Quantiles<Number> quantilesOf(std::vector<Number> values) {
  if (values.empty()) return {};
  const auto p90 = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
  const auto median = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), p90, values.end());
  if (median != p90) std::nth_element(values.begin(), median, p90);  // never above it
  return {*median, *p90};
}

}  // namespace gms_ransac
