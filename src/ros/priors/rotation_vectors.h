// Rotation vectors. (The core has its own in two_view/.)
#pragma once

#include <Eigen/Geometry>

namespace gms_ransac {

/// 99 % quantile of the squared Mahalanobis distance of two rotations, three degrees of freedom.
constexpr double kRotationChi2 = 11.34;

/// The rotation by |v| about v.
inline Eigen::Matrix3d rotationBy(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

/// The inverse.
inline Eigen::Vector3d vectorOf(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd rotation(R);
  return rotation.angle() * rotation.axis();
}

}  // namespace gms_ransac
