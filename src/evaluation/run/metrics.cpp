#include "run/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gms_ransac {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kZeroLength = 1e-12;  // a translation this short has no direction

double degrees(double cosine) { return std::acos(std::min(1.0, std::max(-1.0, cosine))) * 180.0 / M_PI; }

}  // namespace

PoseError poseError(const Eigen::Isometry3d& truth, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  PoseError error;
  error.rotation = degrees(((truth.linear().transpose() * R).trace() - 1) / 2);
  const double length = t.norm(), true_length = truth.translation().norm();
  error.direction = length < kZeroLength ? 90.0 : degrees(t.dot(truth.translation()) / (length * true_length + 1e-15));
  return error;
}

double percentile(std::vector<double> values, double percent) {
  if (values.empty()) return kNone;
  std::sort(values.begin(), values.end());
  const double position = percent / 100.0 * static_cast<double>(values.size() - 1);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (position - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace gms_ransac
