// What another sensor says about how the camera turned between the two images of a pair.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace gms_ransac {

/// How fast the camera turned while the rows of the two images were read: rotation vectors, rad/s, each about the axes
/// of that camera.
struct TurnRates {
  Eigen::Vector3d reference{0, 0, 0}, current{0, 0, 0};
};

/// A turn from a gyro, an odometry or tf. Estimators take it as a proposal: it wins only where the matches support it,
/// and is never averaged into the pose.
struct RotationPrior {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< X_reference = R X_current, as RelativePose::R
  /// Of the rotation vector of exp(rotation vector) R, about the reference camera's axes, rad^2; as in
  /// RelativePose::covariance.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::optional<TurnRates> rates;  ///< where the sensor tells them; used with RobustOptions::rolling_shutter_readout
};

}  // namespace gms_ransac
