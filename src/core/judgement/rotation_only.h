// The motion as a turn alone, and the parallax that no turn explains.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "two_view/pose_model.h"

namespace gms_ransac {

struct RotationOnly {
  Eigen::Matrix3d R;           ///< from reference to current
  double median_residual = 0;  ///< of the inliers, working units: the parallax that no rotation explains
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< t anywhere on the sphere
};

/// Uniform on the unit sphere has a variance of 1/3 in each coordinate.
inline Eigen::Matrix3d anyDirection() { return Eigen::Matrix3d::Identity() / 3; }

/// `inlier_residuals`: Sampson distance of each column, an inlier below 1; `sigma`: of a coordinate, thresholds. Fills
/// `residuals`, the squared transfer distance of each column under the rotation; `sorted`: storage.
RotationOnly fitRotationOnly(const PoseModel& model, const PointColumnsView& points, const TwoViewPose& start,
                             const std::vector<float>& inlier_residuals, double sigma, std::vector<float>& residuals,
                             std::vector<float>& sorted, int64_t& evaluations);

}  // namespace gms_ransac
