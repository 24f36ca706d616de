// The homography for the fast search: hypotheses from four points, refinement on its eight degrees of freedom.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "robust/fast/residual_kernels.h"

namespace gms_ransac {

class HomographyModel {
 public:
  static constexpr int kSampleSize = 4;
  static constexpr int kMaxHypotheses = 1;
  using Hypothesis = Eigen::Matrix3d;

  HomographyModel(const ResidualKernels& kernels, const PointColumnsView& points)
      : kernels_(kernels), points_(points) {}

  /// The homography of a sample (column positions) unless it turns some of its points inside out.
  int generate(const int* sample, Hypothesis* hypotheses) const;
  /// Mean squared transfer distance of both directions; false as soon as the cost is known to exceed `bound`.
  bool score(const Hypothesis& H, float bound, Score& score, int64_t& evaluations) const;
  void residuals(const Hypothesis& H, float* e) const;
  /// Levenberg-Marquardt on the transfer distance in the current image; returns passes over the matches.
  int refine(const Loss& loss, int iterations, Hypothesis& H) const;

 private:
  const ResidualKernels& kernels_;
  PointColumnsView points_;
};

}  // namespace gms_ransac
