// What the essential and the fundamental matrix share: a match is judged by the epipolar lines of a matrix.
#pragma once

#include <cstdint>

#include "two_view/minimal_sample.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

class EpipolarModel : public TwoViewModel {
 public:
  bool score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound, HypothesisScore& score,
             int64_t& evaluations) const override {
    float m[9];
    toFloat(hypothesis.matrix, m);
    kernels_.scoreEpipolar(points, m, bound, score);
    evaluations += score.evaluated;
    return score.cost < bound;
  }
  bool fits(const Hypothesis& hypothesis, int column) const override {
    return epipolarFits(points_, hypothesis.matrix, column);
  }
  void residuals(const Hypothesis& hypothesis, float* e) const override {
    float m[9];
    toFloat(hypothesis.matrix, m);
    kernels_.epipolarResiduals(points_, m, e);
  }
  Eigen::Matrix3d matrix(const Hypothesis& hypothesis) const override { return hypothesis.matrix; }

 protected:
  EpipolarModel(const ResidualKernels& kernels, const PointColumnsView& points) : kernels_(kernels), points_(points) {}

  const ResidualKernels& kernels_;
  PointColumnsView points_;
};

}  // namespace gms_ransac
