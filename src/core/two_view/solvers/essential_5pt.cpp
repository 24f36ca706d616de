#include "two_view/solvers/minimal_solvers.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "two_view/solvers/numerics.h"

namespace gms_ransac {

namespace {

// Monomials of degree <= 3 in (x, y, z), in Nister's order: after elimination of the first ten, rows 4..9 give the
// three equations that are linear in x and y.
enum Cubic {
  kXXX,
  kYYY,
  kXXY,
  kXYY,
  kXXZ,
  kXX,
  kYYZ,
  kYY,
  kXYZ,
  kXY,
  kXZZ,
  kXZ,
  kX,
  kYZZ,
  kYZ,
  kY,
  kZZZ,
  kZZ,
  kZ,
  kOne
};
// Products of two linear forms: xx, xy, xz, x, yy, yz, y, zz, z, 1.
using Linear = double[4];
using Quadratic = double[10];
using System = double[10][20];

inline void addProduct(const Linear& a, const Linear& b, double factor, Quadratic& result) {
  const double a0 = factor * a[0], a1 = factor * a[1], a2 = factor * a[2], a3 = factor * a[3];
  result[0] += a0 * b[0];
  result[1] += a0 * b[1] + a1 * b[0];
  result[2] += a0 * b[2] + a2 * b[0];
  result[3] += a0 * b[3] + a3 * b[0];
  result[4] += a1 * b[1];
  result[5] += a1 * b[2] + a2 * b[1];
  result[6] += a1 * b[3] + a3 * b[1];
  result[7] += a2 * b[2];
  result[8] += a2 * b[3] + a3 * b[2];
  result[9] += a3 * b[3];
}

inline void addProduct(const Quadratic& q, const Linear& l, double* row) {
  row[kXXX] += q[0] * l[0];
  row[kYYY] += q[4] * l[1];
  row[kXXY] += q[0] * l[1] + q[1] * l[0];
  row[kXYY] += q[1] * l[1] + q[4] * l[0];
  row[kXXZ] += q[0] * l[2] + q[2] * l[0];
  row[kXX] += q[0] * l[3] + q[3] * l[0];
  row[kYYZ] += q[4] * l[2] + q[5] * l[1];
  row[kYY] += q[4] * l[3] + q[6] * l[1];
  row[kXYZ] += q[1] * l[2] + q[2] * l[1] + q[5] * l[0];
  row[kXY] += q[1] * l[3] + q[3] * l[1] + q[6] * l[0];
  row[kXZZ] += q[2] * l[2] + q[7] * l[0];
  row[kXZ] += q[2] * l[3] + q[3] * l[2] + q[8] * l[0];
  row[kX] += q[3] * l[3] + q[9] * l[0];
  row[kYZZ] += q[5] * l[2] + q[7] * l[1];
  row[kYZ] += q[5] * l[3] + q[6] * l[2] + q[8] * l[1];
  row[kY] += q[6] * l[3] + q[9] * l[1];
  row[kZZZ] += q[7] * l[2];
  row[kZZ] += q[7] * l[3] + q[8] * l[2];
  row[kZ] += q[8] * l[3] + q[9] * l[2];
  row[kOne] += q[9] * l[3];
}

/// det(E) = 0 and E E^T E - trace(E E^T) E / 2 = 0 for E = x X + y Y + z Z + W; e[3 i + j] is entry (i, j).
void buildSystem(const Linear (&e)[9], System& system) {
  std::fill(&system[0][0], &system[0][0] + 200, 0.0);
  for (int j = 0; j < 3; ++j) {
    const int a = (j + 1) % 3, b = (j + 2) % 3;
    Quadratic minor = {};
    addProduct(e[3 + a], e[6 + b], 1, minor);
    addProduct(e[3 + b], e[6 + a], -1, minor);
    addProduct(minor, e[j], system[9]);
  }
  Quadratic gram[3][3] = {};
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) addProduct(e[3 * i + k], e[3 * j + k], 1, gram[i][j]);
    }
  }
  for (int k = 0; k < 10; ++k) {
    const double half_trace = 0.5 * (gram[0][0][k] + gram[1][1][k] + gram[2][2][k]);
    for (int i = 0; i < 3; ++i) gram[i][i][k] -= half_trace;
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) {
        addProduct(gram[std::min(i, k)][std::max(i, k)], e[3 * k + j], system[3 * i + j]);
      }
    }
  }
}

/// Reduces columns 0..9 to the identity in rows 4..9 (rows 0..3 only to echelon form). False: singular.
bool eliminate(System& system) {
  for (int k = 0; k < 10; ++k) {
    int pivot = k;
    for (int i = k + 1; i < 10; ++i) {
      if (std::abs(system[i][k]) > std::abs(system[pivot][k])) pivot = i;
    }
    if (!(std::abs(system[pivot][k]) > 1e-14)) return false;
    if (pivot != k) std::swap(system[pivot], system[k]);
    const double inverse = 1 / system[k][k];
    for (int j = k; j < 20; ++j) system[k][j] *= inverse;
    for (int i = k + 1; i < 10; ++i) {
      const double factor = system[i][k];
      for (int j = k; j < 20; ++j) system[i][j] -= factor * system[k][j];
    }
  }
  for (int k = 9; k > 4; --k) {
    for (int i = 4; i < k; ++i) {
      const double factor = system[i][k];
      for (int j = 10; j < 20; ++j) system[i][j] -= factor * system[k][j];
    }
  }
  return true;
}

/// One of the three equations p(z) x + q(z) y + r(z) = 0; coefficients in ascending order.
struct Equation {
  double p[4], q[4], r[5];
};

/// upper - z * lower, where the leading monomials cancel.
Equation combine(const double* upper, const double* lower) {
  const double* u = upper;
  const double* l = lower;
  return {{u[kX], u[kXZ] - l[kX], u[kXZZ] - l[kXZ], -l[kXZZ]},
          {u[kY], u[kYZ] - l[kY], u[kYZZ] - l[kYZ], -l[kYZZ]},
          {u[kOne], u[kZ] - l[kOne], u[kZZ] - l[kZ], u[kZZZ] - l[kZZ], -l[kZZZ]}};
}

template <int NA, int NB>
void addProduct(const double (&a)[NA], const double (&b)[NB], double sign, double (&result)[NA + NB - 1]) {
  for (int i = 0; i < NA; ++i) {
    for (int j = 0; j < NB; ++j) result[i + j] += sign * a[i] * b[j];
  }
}

/// Determinant of the three equations' 3x3 coefficient matrix, a polynomial of degree 10 in z.
void determinant(const Equation (&m)[3], double (&result)[11]) {
  std::fill(result, result + 11, 0.0);
  for (int i = 0; i < 3; ++i) {
    const Equation &a = m[(i + 1) % 3], &b = m[(i + 2) % 3];
    double minor[7] = {};
    addProduct(a.p, b.q, 1, minor);
    addProduct(a.q, b.p, -1, minor);
    addProduct(minor, m[i].r, 1, result);
  }
}

/// The (x, y) that satisfy the three equations at a root z of their determinant.
bool solveXY(const Equation (&m)[3], double z, double& x, double& y) {
  double rows[3][3];
  for (int i = 0; i < 3; ++i) {
    rows[i][0] = ((m[i].p[3] * z + m[i].p[2]) * z + m[i].p[1]) * z + m[i].p[0];
    rows[i][1] = ((m[i].q[3] * z + m[i].q[2]) * z + m[i].q[1]) * z + m[i].q[0];
    rows[i][2] = (((m[i].r[4] * z + m[i].r[3]) * z + m[i].r[2]) * z + m[i].r[1]) * z + m[i].r[0];
  }
  double best = 0;
  for (int i = 0; i < 3; ++i) {
    const double *a = rows[i], *b = rows[(i + 1) % 3];
    const double w = a[0] * b[1] - a[1] * b[0];
    if (std::abs(w) <= std::abs(best)) continue;
    best = w;
    x = (a[1] * b[2] - a[2] * b[1]) / w;
    y = (a[2] * b[0] - a[0] * b[2]) / w;
  }
  return best != 0;
}

}  // namespace

int solveEssential5(const double (&x1)[5][2], const double (&x2)[5][2], Eigen::Matrix3d models[10]) {
  double rows[5][9];
  for (int i = 0; i < 5; ++i) {
    const double a[3] = {x1[i][0], x1[i][1], 1}, b[3] = {x2[i][0], x2[i][1], 1};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) rows[i][3 * r + c] = b[r] * a[c];
    }
  }
  double basis[4][9];
  nullSpace(rows, basis);
  // W, whose coefficient is 1, must not be orthogonal to the solution: an uneven mixture of the basis hardly ever is.
  constexpr double kA = 0.73, kB = 0.55, kC = 0.37, kD = 0.18;
  Linear e[9];
  for (int k = 0; k < 9; ++k) {
    const double b0 = basis[0][k], b1 = basis[1][k], b2 = basis[2][k], b3 = basis[3][k];
    e[k][0] = kB * b0 - kA * b1 + kD * b2 - kC * b3;
    e[k][1] = kC * b0 - kD * b1 - kA * b2 + kB * b3;
    e[k][2] = kD * b0 + kC * b1 - kB * b2 - kA * b3;
    e[k][3] = kA * b0 + kB * b1 + kC * b2 + kD * b3;
  }

  System system;
  buildSystem(e, system);
  if (!eliminate(system)) return 0;
  const Equation equations[3] = {combine(system[4], system[5]), combine(system[6], system[7]),
                                 combine(system[8], system[9])};
  double polynomial[11], roots[10];
  determinant(equations, polynomial);
  const int root_count = solvePolynomial(polynomial, 10, roots);

  int count = 0;
  for (int k = 0; k < root_count; ++k) {
    double x = 0, y = 0;
    const double z = roots[k];
    if (!solveXY(equations, z, x, y)) continue;
    Eigen::Matrix3d& E = models[count];
    for (int i = 0; i < 9; ++i) E(i / 3, i % 3) = e[i][0] * x + e[i][1] * y + e[i][2] * z + e[i][3];
    const double norm = E.norm();
    if (!(norm > 0) || !std::isfinite(norm)) continue;
    E *= std::sqrt(2.0) / norm;
    ++count;
  }
  return count;
}

EssentialDecomposition decomposeEssential(const Eigen::Matrix3d& matrix) {
  const Eigen::Matrix3d E = matrix * (std::sqrt(2.0) / matrix.norm());
  // The columns of E are t x r_i: t is along the cross product of any two, the longest is the safest.
  const Eigen::Vector3d products[3] = {E.col(1).cross(E.col(2)), E.col(2).cross(E.col(0)), E.col(0).cross(E.col(1))};
  int best = 0;
  for (int i = 1; i < 3; ++i) {
    if (products[i].squaredNorm() > products[best].squaredNorm()) best = i;
  }
  EssentialDecomposition result;
  result.t = products[best].normalized();
  Eigen::Matrix3d cofactors, cross;
  for (int i = 0; i < 3; ++i) {
    cofactors.col(i) = products[i];
    cross.col(i) = result.t.cross(E.col(i));
  }
  result.R1 = cofactors - cross;
  result.R2 = cofactors + cross;
  return result;
}

}  // namespace gms_ransac
