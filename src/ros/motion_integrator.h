// Relative poses chained to a pose in the odometry frame, with covariance; and the same for a base frame that carries
// the camera. Knows no topic.
#pragma once

#include <Eigen/Geometry>

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Pose and velocity of a moving frame. Order of the covariances: x y z, then rotation about x y z; perturbations are
/// additive for translations and on the left for rotations, in the axes the quantity is expressed in.
struct OdometryEstimate {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< moving frame in the odometry frame
  Matrix6d pose_covariance = Matrix6d::Zero();
  Vector6d twist = Vector6d::Zero();  ///< linear, angular; in the moving frame; per second
  Matrix6d twist_covariance = Matrix6d::Zero();
};

class MotionIntegrator {
 public:
  /// The odometry frame is the camera at the next image.
  void restart();
  /// A motion was missed: it is taken to be about as large as the last one known, in any direction.
  void lose();
  /// Adds the motion of one pair; `seconds` (> 0) lie between the two images. With `hold_reference` the next pair
  /// starts from the same reference as this one. `translation_known` is false when t is zero for want of parallax.
  void add(const RelativePose& current_in_reference, bool translation_known, double seconds, bool hold_reference);

  /// Length of the last known translation, in its unit; 0: none is known.
  double step() const { return step_; }
  /// Of the camera at the last image added.
  const OdometryEstimate& camera() const { return current_; }
  /// Of a base frame on the same rigid body. The odometry frame is then the base frame at the first image.
  OdometryEstimate base(const Eigen::Isometry3d& camera_in_base) const;

 private:
  OdometryEstimate reference_, current_;
  double step_ = 0, turn_ = 0;  ///< size of the last known motion: translation's unit, radians
};

}  // namespace gms_ransac
