// Five-point essential matrix (Nister, "An efficient solution to the five-point relative pose problem", PAMI 2004).
#pragma once

#include <Eigen/Core>

namespace gms_ransac {

/// x1, x2: normalised image coordinates of five correspondences in the reference (1) and current (2) image.
/// Writes every real E with x2^T E x1 = 0, of Frobenius norm sqrt(2), and returns their number (0..10). Degenerate
/// samples give few, none or meaningless solutions, but always finite ones.
int solveEssential5(const double (&x1)[5][2], const double (&x2)[5][2], Eigen::Matrix3d models[10]);

/// The two rotations and the translation of an essential matrix without an SVD (Horn 1990): with |E|^2 = 2 and
/// E = [t]x R, cof(E) = t t^T R and [t]x E = (t t^T - I) R. The four poses are (R1 or R2, t or -t), from reference to
/// current: X_current = R X_reference + t.
struct EssentialDecomposition {
  Eigen::Matrix3d R1, R2;
  Eigen::Vector3d t;  ///< unit length
};
EssentialDecomposition decomposeEssential(const Eigen::Matrix3d& E);

}  // namespace gms_ransac
