// The residuals of the three models, in double: the definition that the final inlier masks are checked against.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gms_ransac {

/// Squared Sampson distance to x_current^T M x_reference = 0 (Hartley & Zisserman, eq. 11.9). NaN at both epipoles.
inline double sampsonSquared(const Eigen::Matrix3d& M, double x_reference, double y_reference, double x_current,
                             double y_current) {
  const Eigen::Vector3d reference(x_reference, y_reference, 1), current(x_current, y_current, 1);
  const Eigen::Vector3d line_current = M * reference, line_reference = M.transpose() * current;
  const double algebraic = current.dot(line_current);
  return algebraic * algebraic / (line_current.head<2>().squaredNorm() + line_reference.head<2>().squaredNorm());
}

/// Mean of the two squared transfer distances of a homography (Hartley & Zisserman, eq. 4.7, halved).
inline double transferSquared(const Eigen::Matrix3d& H, const Eigen::Matrix3d& H_inverse, double x_reference,
                              double y_reference, double x_current, double y_current) {
  const Eigen::Vector3d forward = H * Eigen::Vector3d(x_reference, y_reference, 1);
  const Eigen::Vector3d backward = H_inverse * Eigen::Vector3d(x_current, y_current, 1);
  const Eigen::Vector2d in_current = forward.hnormalized() - Eigen::Vector2d(x_current, y_current);
  const Eigen::Vector2d in_reference = backward.hnormalized() - Eigen::Vector2d(x_reference, y_reference);
  return 0.5 * (in_current.squaredNorm() + in_reference.squaredNorm());
}

}  // namespace gms_ransac
