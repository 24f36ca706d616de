// What the models share between columns and solvers.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "two_view/residual.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

/// The points of a minimal sample as the solvers take them.
template <int kSize>
struct MinimalSample {
  double reference[kSize][2], current[kSize][2];

  MinimalSample(const PointColumnsView& points, const int* sample) {
    for (int k = 0; k < kSize; ++k) {
      const int i = sample[k];
      reference[k][0] = points.x1[i];
      reference[k][1] = points.y1[i];
      current[k][0] = points.x2[i];
      current[k][1] = points.y2[i];
    }
  }
};

/// Copies the matrices that are finite; returns how many.
inline int keepFinite(const Eigen::Matrix3d* matrices, int count, Hypothesis* hypotheses) {
  int finite = 0;
  for (int k = 0; k < count; ++k) {
    if (matrices[k].allFinite()) hypotheses[finite++].matrix = matrices[k];
  }
  return finite;
}

/// Row-major copy in float.
inline void toFloat(const Eigen::Matrix3d& m, float (&out)[9]) {
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(m(i / 3, i % 3));
}

/// TwoViewModel::fits of a matrix by its epipolar lines.
inline bool epipolarFits(const PointColumnsView& points, const Eigen::Matrix3d& matrix, int i) {
  return points.weight[i] * sampsonSquared(matrix, points.x1[i], points.y1[i], points.x2[i], points.y2[i]) < 1;
}

}  // namespace gms_ransac
