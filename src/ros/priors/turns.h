// Rotation vectors. (The core has its own in two_view/.)
#pragma once

#include <Eigen/Geometry>

namespace gms_ransac {

/// 99 % quantile of the squared Mahalanobis distance of two rotations, three degrees of freedom.
constexpr double kTurnChi2 = 11.34;

/// The rotation by |v| about v.
inline Eigen::Matrix3d turnOf(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

/// The inverse.
inline Eigen::Vector3d vectorOf(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

}  // namespace gms_ransac
