// What most of some numbers are: their median, and what a tenth of them exceeds.
#pragma once

#include <algorithm>
#include <vector>

namespace gms_ransac {

template <typename Number>
struct Quantiles {
  Number median = 0, p90 = 0;
};

/// Zeros of none.
template <typename Number>
Quantiles<Number> quantilesOf(std::vector<Number> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  return {values[values.size() / 2], values[values.size() * 9 / 10]};
}

}  // namespace gms_ransac
