// Errors of a pose, and order statistics.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

namespace gms_ransac {

constexpr double kDegrees = 180 / M_PI;  ///< in a radian

/// Errors of an estimated relative pose, degrees; at first those of a pair without a pose.
struct PoseError {
  double rotation = 180;   ///< angle of R_true^T R
  double direction = 180;  ///< angle between the translations; 90 when the estimate is zero
};

/// Both poses are current_in_reference (X_reference = R X_current + t).
inline PoseError poseError(const Eigen::Isometry3d& truth, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  constexpr double kZeroLength = 1e-12;  // a translation this short has no direction
  const auto degrees = [](double cosine) { return std::acos(std::min(1.0, std::max(-1.0, cosine))) * 180.0 / M_PI; };
  const double length = t.norm(), true_length = truth.translation().norm();
  return {degrees(((truth.linear().transpose() * R).trace() - 1) / 2),
          length < kZeroLength ? 90.0 : degrees(t.dot(truth.translation()) / (length * true_length + 1e-15))};
}

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
