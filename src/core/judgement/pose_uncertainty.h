// How well the matches determine a pose: covariance from the normal equations, parallax from the best rotation alone.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/relative_pose.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// Covariance of `pose` in the project's convention (see RelativePose), to first order, with the noise estimated from
/// the residuals of the inliers. Nothing along t, and nothing between t and the rotation: the estimator takes them from
/// two optima, with and without the prior of the parallax, and the correlation at either is not theirs.
Eigen::Matrix<double, 6, 6> poseCovariance(const PoseModel& model, int count, const TwoViewPose& pose);

/// The motion as a rotation only.
struct RotationOnly {
  Eigen::Matrix3d R;           ///< from reference to current
  double median_residual = 0;  ///< of the inliers, working units: the parallax that no rotation explains
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< t anywhere on the sphere
};

/// `inlier_residuals`: Sampson distance of each column, an inlier below 1; `residuals`: room for all columns.
RotationOnly fitRotationOnly(const PoseModel& model, const PointColumnsView& points, const TwoViewPose& start,
                             const std::vector<float>& inlier_residuals, std::vector<float>& residuals,
                             int64_t& evaluations);

}  // namespace gms_ransac
