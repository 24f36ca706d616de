// The relative pose of two images, and a rotation measured by another sensor. The convention of the whole project
// is fixed here.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace gms_ransac {

/// Covariance of a translation and a rotation vector, order x y z rx ry rz. Eigen would align a matrix of this size as
/// wide as the vectors that a program is compiled for; this one has the same layout in a library and in a program built
/// with -march=native.
using Covariance6d = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;
static_assert(sizeof(Covariance6d) == 36 * sizeof(double) && alignof(Covariance6d) == alignof(double),
              "gms_ransac: the layout of public types must not depend on compiler flags");

/// Pose of the current camera in the reference camera frame: X_reference = R X_current + t, optical frames.
/// cv::recoverPose gives the inverse.
struct RelativePose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();  ///< unit length unless a scale is known
  /// Perturbs t additively and R as exp(rotation vector) R; a unit-length t has no extent along t.
  Covariance6d covariance = Covariance6d::Zero();
};
static_assert(sizeof(RelativePose) == (9 + 3 + 36) * sizeof(double) && alignof(RelativePose) == alignof(double),
              "gms_ransac: the layout of public types must not depend on compiler flags");

struct PoseParameters;

/// The motion of a pair as estimators have it, X_current = R X_reference + t with |t| = 1.
struct TwoViewPose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitZ();

  Eigen::Matrix3d essential() const;
  PoseParameters parameters() const;
};

/// From X_current = R X_reference + t to the project's convention, without covariance.
inline RelativePose fromReferenceToCurrent(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  RelativePose pose;
  pose.R = R.transpose();
  pose.t = -(pose.R * t);
  return pose;
}

/// Angular velocities while the rows of the images were read: rotation vectors, rad/s, each in that camera's axes.
struct RotationRates {
  Eigen::Vector3d reference{0, 0, 0}, current{0, 0, 0};
};

/// Rotation from a gyro, an odometry or tf. A proposal for estimators: it wins only where the matches support it.
struct RotationPrior {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< X_reference = R X_current, as RelativePose::R
  /// Of the rotation vector of exp(rotation vector) R, reference camera's axes, rad^2.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::optional<RotationRates> rates;  ///< if measured; used with RobustOptions::rolling_shutter_readout
};

}  // namespace gms_ransac
