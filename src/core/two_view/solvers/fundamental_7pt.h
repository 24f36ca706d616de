// Seven-point fundamental matrix (Hartley and Zisserman, Multiple View Geometry, 11.1.2).
#pragma once

#include <Eigen/Core>

namespace gms_ransac {

/// x1, x2: seven correspondences in any units (pixels are fine: they are centred and scaled inside).
/// Writes every real F with x2^T F x1 = 0 and det F = 0, of unit Frobenius norm, and returns their number (0..3).
int solveFundamental7(const double (&x1)[7][2], const double (&x2)[7][2], Eigen::Matrix3d models[3]);

}  // namespace gms_ransac
