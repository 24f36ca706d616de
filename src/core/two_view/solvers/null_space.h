// Orthonormal null spaces of the small coefficient matrices of the minimal solvers.
#pragma once

#include <cmath>

namespace gms_ransac {

/// `rows` holds M equations in N unknowns (destroyed). Writes N - M orthonormal vectors that satisfy all of them, by
/// Householder reflections of the transposed matrix: unlike elimination the result stays well conditioned when the
/// equations are nearly dependent. Dependent equations are skipped, so the vectors always satisfy the others.
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
