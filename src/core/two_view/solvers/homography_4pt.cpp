#include "two_view/solvers/minimal_solvers.h"

#include <cmath>

#include <Eigen/LU>

#include "two_view/solvers/numerics.h"

namespace gms_ransac {

namespace {

// Twice the area of a triangle of normalised points below which they count as collinear.
constexpr double kCollinear = 1e-9;

/// Maps the unit vectors and (1, 1, 1) to the four points. False: three are collinear.
bool projectiveBasis(const double (&x)[4][2], const PointNormalization& n, Eigen::Matrix3d& basis) {
  double p[4][2];
  for (int i = 0; i < 4; ++i) {
    p[i][0] = n.x(x[i][0]);
    p[i][1] = n.y(x[i][1]);
  }
  const auto area = [&p](int a, int b, int c) {
    return (p[b][0] - p[a][0]) * (p[c][1] - p[a][1]) - (p[c][0] - p[a][0]) * (p[b][1] - p[a][1]);
  };
  const double whole = area(0, 1, 2);
  const double parts[3] = {area(3, 1, 2), area(0, 3, 2), area(0, 1, 3)};
  if (!(std::abs(whole) > kCollinear)) return false;
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(parts[i]) > kCollinear)) return false;
    basis.col(i) = parts[i] / whole * Eigen::Vector3d(p[i][0], p[i][1], 1);
  }
  return true;
}

}  // namespace

int solveHomography4(const double (&x1)[4][2], const double (&x2)[4][2], Eigen::Matrix3d models[1]) {
  const auto n1 = PointNormalization::of(x1), n2 = PointNormalization::of(x2);
  Eigen::Matrix3d basis1, basis2;
  if (!projectiveBasis(x1, n1, basis1) || !projectiveBasis(x2, n2, basis2)) return 0;
  const Eigen::Matrix3d H = n2.inverse() * (basis2 * basis1.inverse()) * n1.matrix();
  const double norm = H.norm();
  if (!(norm > 0) || !std::isfinite(norm)) return 0;
  models[0] = H / norm;
  return 1;
}

}  // namespace gms_ransac
