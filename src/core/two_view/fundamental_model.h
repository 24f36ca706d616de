// The fundamental matrix: hypotheses from seven points, refinement on its seven degrees of freedom.
#pragma once

#include "two_view/epipolar_model.h"

namespace gms_ransac {

class FundamentalModel : public EpipolarModel {
 public:
  /// `oriented`: only solutions that see the sample on one side of the cameras are kept (the oriented epipolar
  /// constraint, Chum, Werner & Matas 2004).
  FundamentalModel(const ResidualKernels& kernels, const PointColumnsView& points, bool oriented)
      : EpipolarModel(kernels, points), oriented_(oriented) {}

  int sampleSize() const override { return 7; }
  int solve(const int* sample, Hypothesis* hypotheses) const override;
  /// Levenberg-Marquardt over F = U diag(1, s, 0) V^T.
  int refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const override;

 private:
  bool oriented_;
};

}  // namespace gms_ransac
