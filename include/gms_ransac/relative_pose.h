// The relative pose of two images, and a rotation measured by another sensor. X_reference = R X_current + t is the
// convention of everything that a user sees.
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

struct TwoViewPose;

/// A motion from which the search of the next pair may start. It goes from one answer to the next; only estimators look
/// into it.
class MotionStart {
 public:
  explicit MotionStart(const TwoViewPose& pose);
  TwoViewPose pose() const;

 private:
  Eigen::Matrix3d R_;
  Eigen::Vector3d t_;
};

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
