// Five-point essential matrix (Nister, "An efficient solution to the five-point relative pose problem", PAMI 2004).
#pragma once

#include <Eigen/Core>

namespace gms_ransac {

/// x1, x2: normalised coordinates of five correspondences. Writes every real E with x2^T E x1 = 0, of norm sqrt(2), and
/// returns their number (0..10). Degenerate samples give finite solutions, if any.
int solveEssential5(const double (&x1)[5][2], const double (&x2)[5][2], Eigen::Matrix3d models[10]);

/// Rotations and translation of an essential matrix without an SVD (Horn 1990). The four poses are (R1 or R2, t or -t):
/// X_current = R X_reference + t.
struct EssentialDecomposition {
  Eigen::Matrix3d R1, R2;
  Eigen::Vector3d t;  ///< unit length
};
EssentialDecomposition decomposeEssential(const Eigen::Matrix3d& E);

/// Seven correspondences in any units. Writes every F with x2^T F x1 = 0 and det F = 0, of unit norm; returns 0..3.
int solveFundamental7(const double (&x1)[7][2], const double (&x2)[7][2], Eigen::Matrix3d models[3]);

/// Four correspondences in any units. Writes H with x2 ~ H x1, of unit norm, and returns 1; 0 if three are collinear.
int solveHomography4(const double (&x1)[4][2], const double (&x2)[4][2], Eigen::Matrix3d models[1]);

/// Distinct real roots of c[0] + ... + c[degree] x^degree, degree <= 10, ascending, to about 1e-13 relative. Leading
/// coefficients may be zero. Returns their number, at most the degree.
int solvePolynomial(const double* c, int degree, double (&roots)[10]);

}  // namespace gms_ransac
