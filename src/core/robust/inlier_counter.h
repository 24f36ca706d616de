// Scores models on a run of ordered matches with the SIMD kernels, always on every match, as the literal methods do.
#pragma once

#include <cstdint>
#include <vector>

#include "robust/fast/point_columns.h"
#include "robust/fast/residual_kernels.h"
#include "robust/two_view_problem.h"

namespace gms_ransac {

/// Refinement of a model found by sampling: matches up to twice the threshold, weights falling from the threshold on
/// (Geman-McClure); it converges in four to eight iterations on the scenes of the tests.
constexpr Loss kRefinementLoss = {4, 1};
constexpr int kRefinementIterations = 15;

class InlierCounter {
 public:
  explicit InlierCounter(SimdLevel level) : kernels_(&residualKernels(level)) {}
  /// Takes a copy of points[begin, end).
  void set(const TwoViewProblem& problem, const OrderedPoints& points, int begin, int end);
  int size() const { return columns_.count(); }
  /// Inliers and truncated cost of a model in the working coordinates of the problem.
  Score score(const Eigen::Matrix3d& model) const;
  /// One entry a match: 1 where its residual is within the threshold.
  void mark(const Eigen::Matrix3d& model, std::vector<uint8_t>& inlier);
  /// Moves a fundamental matrix or homography to the robust optimum near it; returns passes over the matches.
  int refine(Eigen::Matrix3d& model) const;

 private:
  const ResidualKernels* kernels_;
  ModelType type_ = ModelType::kEssential;
  PointColumns columns_;
  std::vector<float> residuals_;
};

}  // namespace gms_ransac
