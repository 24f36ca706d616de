// The fundamental matrix for the fast search: hypotheses from seven points, refinement on its seven degrees of freedom.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "robust/fast/residual_kernels.h"

namespace gms_ransac {

class FundamentalModel {
 public:
  static constexpr int kSampleSize = 7;
  static constexpr int kMaxHypotheses = 3;
  using Hypothesis = Eigen::Matrix3d;

  FundamentalModel(const ResidualKernels& kernels, const PointColumnsView& points)
      : kernels_(kernels), points_(points) {}

  /// Matrices of a sample (column positions) that see its points on one side of the cameras (the oriented epipolar
  /// constraint, Chum, Werner & Matas 2004).
  int generate(const int* sample, Hypothesis* hypotheses) const;
  /// False as soon as the cost is known to exceed `bound`.
  bool score(const Hypothesis& F, float bound, Score& score, int64_t& evaluations) const;
  void residuals(const Hypothesis& F, float* e) const;
  /// Levenberg-Marquardt over F = U diag(1, s, 0) V^T; returns passes over the matches.
  int refine(const Loss& loss, int iterations, Hypothesis& F) const;

 private:
  const ResidualKernels& kernels_;
  PointColumnsView points_;
};

}  // namespace gms_ransac
