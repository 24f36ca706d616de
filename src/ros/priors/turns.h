// Rotation vectors and their limit, for what compares turns. (The core has its own in two_view/, which is not for
// others to include.)
#pragma once

#include <Eigen/Geometry>

namespace gms_ransac {

/// Of the squared Mahalanobis distance of two turns, three freedoms: what chance exceeds once in a hundred.
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
