// Centring of minimal samples, so that solvers take any units, and null spaces of small matrices.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace gms_ransac {

/// Maps p to scale * (p - centre): zero mean, mean squared distance 2 (Hartley 1997).
struct PointNormalization {
  double centre_x = 0, centre_y = 0, scale = 1;

  template <int N>
  static PointNormalization of(const double (&points)[N][2]) {
    PointNormalization n;
    for (const auto& p : points) {
      n.centre_x += p[0] / N;
      n.centre_y += p[1] / N;
    }
    double squares = 0;
    for (const auto& p : points) {
      squares += (p[0] - n.centre_x) * (p[0] - n.centre_x) + (p[1] - n.centre_y) * (p[1] - n.centre_y);
    }
    if (squares > 0) n.scale = std::sqrt(2.0 * N / squares);
    return n;
  }

  double x(double value) const { return scale * (value - centre_x); }
  double y(double value) const { return scale * (value - centre_y); }
  Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d T;
    T << scale, 0, -scale * centre_x, 0, scale, -scale * centre_y, 0, 0, 1;
    return T;
  }
  Eigen::Matrix3d inverse() const {
    Eigen::Matrix3d T;
    T << 1 / scale, 0, centre_x, 0, 1 / scale, centre_y, 0, 0, 1;
    return T;
  }
};

/// Writes N - M orthonormal vectors that satisfy the M equations (destroyed), by Householder reflections: well
/// conditioned when they are nearly dependent.
template <int M, int N>
void nullSpace(double (&rows)[M][N], double (&basis)[N - M][N]) {
  double scale[M];  // 2 / |v|^2 of the reflection kept in rows[k][k..N), 0: no reflection
  for (int k = 0; k < M; ++k) {
    double* v = rows[k];
    double squared_norm = 0;
    for (int i = k; i < N; ++i) squared_norm += v[i] * v[i];
    scale[k] = 0;
    if (!(squared_norm > 1e-28)) continue;
    v[k] += std::copysign(std::sqrt(squared_norm), v[k]);
    double squared_length = 0;
    for (int i = k; i < N; ++i) squared_length += v[i] * v[i];
    scale[k] = 2 / squared_length;
    for (int j = k + 1; j < M; ++j) {
      double dot = 0;
      for (int i = k; i < N; ++i) dot += v[i] * rows[j][i];
      dot *= scale[k];
      for (int i = k; i < N; ++i) rows[j][i] -= dot * v[i];
    }
  }
  for (int b = 0; b < N - M; ++b) {
    double* x = basis[b];
    for (int i = 0; i < N; ++i) x[i] = i == M + b ? 1 : 0;
    for (int k = M - 1; k >= 0; --k) {
      const double* v = rows[k];
      double dot = 0;
      for (int i = k; i < N; ++i) dot += v[i] * x[i];
      dot *= scale[k];
      for (int i = k; i < N; ++i) x[i] -= dot * v[i];
    }
  }
}

}  // namespace gms_ransac
