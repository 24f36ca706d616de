// The fundamental matrix: hypotheses from seven points, refinement on its seven degrees of freedom.
#pragma once

#include <Eigen/Core>

#include "two_view/two_view_model.h"

namespace gms_ransac {

class FundamentalModel : public EpipolarModel {
 public:
  /// `oriented`: keeps solutions with the sample on one side of the cameras (Chum, Werner & Matas 2004).
  FundamentalModel(const ResidualKernels& kernels, const PointColumnsView& points, bool oriented)
      : EpipolarModel(kernels, points), oriented_(oriented) {}

  int sampleSize() const override { return 7; }
  int solve(const int* sample, Hypothesis* hypotheses) const override;
  void refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const override;

 private:
  bool oriented_;
};

class HomographyModel : public TwoViewModel {
 public:
  /// `oriented`: drops homographies with sample points on both sides of the camera.
  HomographyModel(const ResidualKernels& kernels, const PointColumnsView& points, bool oriented)
      : TwoViewModel(kernels, points), oriented_(oriented) {}

  int sampleSize() const override { return 4; }
  int solve(const int* sample, Hypothesis* hypotheses) const override;
  bool score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound,
             HypothesisScore& score) const override;
  bool fits(const Hypothesis& hypothesis, int slot) const override;
  void residuals(const Hypothesis& hypothesis, std::vector<float>& e) const override;
  void refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const override;
  Eigen::Matrix3d matrix(const Hypothesis& hypothesis) const override { return hypothesis.matrix; }

 private:
  bool oriented_;
};

}  // namespace gms_ransac
