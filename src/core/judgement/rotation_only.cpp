#include "judgement/rotation_only.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "order_statistics.h"

namespace gms_ransac {

namespace {

// Inliers within this many squared thresholds make the estimate of the noise and the information.
constexpr float kInlierCut = 1;
// Of a coordinate: a transfer distance has the noise of both images, and two of its deviations are let in.
constexpr double kSoftnessVariances = 2 * 2 * 2;

Eigen::Matrix3d inverseOf(const NormalEquations<3>& equations) {
  Eigen::Matrix3d A;
  int k = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) A(i, j) = A(j, i) = equations.matrix[k++];
  }
  const Eigen::LDLT<Eigen::Matrix3d> factors(A);
  if (factors.info() != Eigen::Success || !factors.isPositive()) return Eigen::Matrix3d::Identity();
  return factors.solve(Eigen::Matrix3d::Identity());
}

/// Variance of a residual in squared thresholds, from the truncated cost.
double noiseVariance(const NormalEquations<3>& equations, int count) {
  constexpr int kComponents = 2, kFreedoms = 3;
  const double inliers = equations.weight;
  const double squares = equations.cost - kInlierCut * (count - inliers);
  return std::max(squares, 1e-12) / std::max(1.0, kComponents * inliers - kFreedoms);
}

}  // namespace

RotationOnly fitRotationOnly(const PoseModel& model, const PointColumnsView& points, const TwoViewPose& start,
                             const std::vector<float>& inlier_residuals, double sigma, std::vector<float>& residuals,
                             std::vector<float>& sorted, int64_t& evaluations) {
  constexpr int kIterations = 3;
  RotationOnly result;
  result.R = start.R;
  // From ten pixels at a threshold of one to the threshold's own scale, or twice what noise of both images amounts to:
  // near points of a translating camera drop out.
  const auto noise = static_cast<float>(kSoftnessVariances * sigma * sigma);
  for (float softness : {100.f, 10.f, 2.f, std::min(2.f, noise)}) {
    const Loss loss = {1e12f, 1 / softness};
    evaluations += static_cast<int64_t>(points.count) * model.refineRotation(loss, kIterations, result.R);
  }
  model.rotationResiduals(result.R, residuals.data());
  evaluations += points.count;
  sorted.clear();
  for (int i = 0; i < points.count; ++i) {
    if (inlier_residuals[static_cast<size_t>(i)] >= 1) continue;
    sorted.push_back(std::sqrt(residuals[static_cast<size_t>(i)] / points.weight[i]));
  }
  if (!sorted.empty()) result.median_residual = nthSmallest(sorted, sorted.size() / 2);

  NormalEquations<3> equations;
  model.linearizeRotation(result.R, {kInlierCut, 0}, equations);
  const Eigen::Matrix3d Rt = result.R.transpose();
  result.covariance.bottomRightCorner<3, 3>() =
      noiseVariance(equations, points.count) * (Rt * inverseOf(equations) * result.R);
  result.covariance.topLeftCorner<3, 3>() = anyDirection();
  return result;
}

}  // namespace gms_ransac
