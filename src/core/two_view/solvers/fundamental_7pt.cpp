#include "two_view/solvers/minimal_solvers.h"

#include <cmath>

#include "two_view/solvers/numerics.h"

namespace gms_ransac {

namespace {

/// Coefficients of det(G + z H), row-major 3x3 arrays, in ascending order of z.
void determinantPencil(const double (&g)[9], const double (&h)[9], double (&c)[4]) {
  c[0] = c[1] = c[2] = c[3] = 0;
  for (int j = 0; j < 3; ++j) {
    const int a = (j + 1) % 3, b = (j + 2) % 3;
    const double minor0 = g[3 + a] * g[6 + b] - g[3 + b] * g[6 + a];
    const double minor1 = g[3 + a] * h[6 + b] + h[3 + a] * g[6 + b] - g[3 + b] * h[6 + a] - h[3 + b] * g[6 + a];
    const double minor2 = h[3 + a] * h[6 + b] - h[3 + b] * h[6 + a];
    c[0] += g[j] * minor0;
    c[1] += g[j] * minor1 + h[j] * minor0;
    c[2] += g[j] * minor2 + h[j] * minor1;
    c[3] += h[j] * minor2;
  }
}

}  // namespace

int solveFundamental7(const double (&x1)[7][2], const double (&x2)[7][2], Eigen::Matrix3d models[3]) {
  const auto n1 = PointNormalization::of(x1), n2 = PointNormalization::of(x2);
  double rows[7][9];
  for (int i = 0; i < 7; ++i) {
    const double a[3] = {n1.x(x1[i][0]), n1.y(x1[i][1]), 1}, b[3] = {n2.x(x2[i][0]), n2.y(x2[i][1]), 1};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) rows[i][3 * r + c] = b[r] * a[c];
    }
  }
  double basis[2][9];
  nullSpace(rows, basis);
  // An uneven mixture, so that the symmetries of sideways or forward motion do not send a root to infinity.
  constexpr double kCos = 0.54, kSin = 0.84;
  double g[9], h[9], c[4], roots[10];
  for (int k = 0; k < 9; ++k) {
    g[k] = kCos * basis[0][k] + kSin * basis[1][k];
    h[k] = kCos * basis[1][k] - kSin * basis[0][k];
  }
  determinantPencil(g, h, c);
  const int root_count = solvePolynomial(c, 3, roots);

  const Eigen::Matrix3d T1 = n1.matrix(), T2t = n2.matrix().transpose();
  int count = 0;
  for (int k = 0; k < root_count; ++k) {
    Eigen::Matrix3d F;
    for (int i = 0; i < 9; ++i) F(i / 3, i % 3) = g[i] + roots[k] * h[i];
    F = T2t * F * T1;
    const double norm = F.norm();
    if (!(norm > 0) || !std::isfinite(norm)) continue;
    models[count++] = F / norm;
  }
  return count;
}

}  // namespace gms_ransac
