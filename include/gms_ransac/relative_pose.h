// Last stage, model -> relative pose. The convention of the whole project is fixed here.
#pragma once

#include <Eigen/Core>

namespace gms_ransac {

/// Pose of the current camera in the reference camera frame: X_reference = R X_current + t, both optical frames
/// (x right, y down, z forward). cv::recoverPose(reference, current) gives the inverse; `fromReferenceToCurrent`
/// is the one place where that is turned round.
struct RelativePose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();  ///< unit length unless a scale is known
  /// Covariance of (t, rotation vector), order x y z rx ry rz as in geometry_msgs/PoseWithCovariance, perturbing
  /// t additively and R as exp(rotation vector) R; for the unit-length t it has no extent along t.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// From X_current = R X_reference + t to the project's convention. Covariance is left at zero.
RelativePose fromReferenceToCurrent(const Eigen::Matrix3d& R, const Eigen::Vector3d& t);

}  // namespace gms_ransac
