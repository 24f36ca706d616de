// Median and percentiles.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

namespace gms_ransac {

/// Linear interpolation between order statistics (numpy's default); NaN without values. `percent` 0..100.
inline double percentile(std::vector<double> values, double percent) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double position = percent / 100.0 * static_cast<double>(values.size() - 1);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (position - static_cast<double>(below)) * (values[above] - values[below]);
}
inline double median(const std::vector<double>& values) { return percentile(values, 50); }

}  // namespace gms_ransac
