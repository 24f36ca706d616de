// Errors of a pose, and order statistics.
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace gms_ransac {

constexpr double kDegrees = 180 / M_PI;  ///< in a radian

/// Error given to a pair without a pose, degrees.
constexpr double kFailedPoseError = 180.0;

/// Errors of an estimated relative pose, degrees.
struct PoseError {
  double rotation = kFailedPoseError;   ///< angle of R_true^T R
  double direction = kFailedPoseError;  ///< angle between the translations; 90 when the estimate is zero
  double worst() const { return rotation > direction ? rotation : direction; }
};

/// Both poses are current_in_reference (X_reference = R X_current + t).
PoseError poseError(const Eigen::Isometry3d& truth, const Eigen::Matrix3d& R, const Eigen::Vector3d& t);

/// Linear interpolation between order statistics (numpy's default); NaN without values. `percent` 0..100.
double percentile(std::vector<double> values, double percent);
inline double median(const std::vector<double>& values) { return percentile(values, 50); }

}  // namespace gms_ransac
