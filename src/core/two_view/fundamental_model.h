// The fundamental matrix: hypotheses from seven points, refinement on its seven degrees of freedom.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "two_view/two_view_model.h"

namespace gms_ransac {

class FundamentalModel : public TwoViewModel {
 public:
  /// `oriented`: only solutions that see the sample on one side of the cameras are kept (the oriented epipolar
  /// constraint, Chum, Werner & Matas 2004).
  FundamentalModel(const ResidualKernels& kernels, const PointColumnsView& points, bool oriented)
      : kernels_(kernels), points_(points), oriented_(oriented) {}

  int sampleSize() const override { return 7; }
  int solve(const int* sample, Hypothesis* hypotheses) const override;
  bool score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound, Score& score,
             int64_t& evaluations) const override;
  bool fits(const Hypothesis& hypothesis, int column) const override;
  void residuals(const Hypothesis& hypothesis, float* e) const override;
  /// Levenberg-Marquardt over F = U diag(1, s, 0) V^T.
  int refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const override;
  Eigen::Matrix3d matrix(const Hypothesis& hypothesis) const override { return hypothesis.matrix; }

 private:
  const ResidualKernels& kernels_;
  PointColumnsView points_;
  bool oriented_;
};

}  // namespace gms_ransac
