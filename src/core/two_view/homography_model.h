// The homography: hypotheses from four points, refinement on its eight degrees of freedom.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "two_view/two_view_model.h"

namespace gms_ransac {

class HomographyModel : public TwoViewModel {
 public:
  /// `oriented`: a homography that turns some of its sample inside out is left out.
  HomographyModel(const ResidualKernels& kernels, const PointColumnsView& points, bool oriented)
      : kernels_(kernels), points_(points), oriented_(oriented) {}

  int sampleSize() const override { return 4; }
  int solve(const int* sample, Hypothesis* hypotheses) const override;
  /// By the mean squared transfer distance of both directions.
  bool score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound, HypothesisScore& score,
             int64_t& evaluations) const override;
  bool fits(const Hypothesis& hypothesis, int column) const override;
  void residuals(const Hypothesis& hypothesis, float* e) const override;
  /// Levenberg-Marquardt on the transfer distance in the current image.
  int refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const override;
  Eigen::Matrix3d matrix(const Hypothesis& hypothesis) const override { return hypothesis.matrix; }

 private:
  const ResidualKernels& kernels_;
  PointColumnsView points_;
  bool oriented_;
};

}  // namespace gms_ransac
