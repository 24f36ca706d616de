#include "judgement/pose_uncertainty.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

// Inliers within this many squared thresholds make the estimate of the noise and the information.
constexpr float kInlierCut = 1;

template <int P>
Eigen::Matrix<double, P, P> inverseOf(const NormalEquations<P>& equations) {
  Eigen::Matrix<double, P, P> A;
  int k = 0;
  for (int i = 0; i < P; ++i) {
    for (int j = i; j < P; ++j) A(i, j) = A(j, i) = equations.matrix[k++];
  }
  const Eigen::LDLT<Eigen::Matrix<double, P, P>> factors(A);
  if (factors.info() != Eigen::Success || !factors.isPositive()) return Eigen::Matrix<double, P, P>::Identity();
  return factors.solve(Eigen::Matrix<double, P, P>::Identity());
}

/// Variance of a residual in squared thresholds, from the truncated cost.
template <int P>
double noiseVariance(const NormalEquations<P>& equations, int count, int components) {
  const double inliers = equations.weight;
  const double squares = equations.cost - kInlierCut * (count - inliers);
  return std::max(squares, 1e-12) / std::max(1.0, components * inliers - P);
}

}  // namespace

Eigen::Matrix<double, 6, 6> poseCovariance(const PoseModel& model, int count, const TwoViewPose& pose) {
  NormalEquations<5> equations;
  model.linearize(pose, {kInlierCut, 0}, equations);
  // Parameters: rotation vector w with R <- exp(w) R, and the steps of t along the tangent vectors. With
  // R' = R^T and t' = -R^T t: R' <- exp(-R^T w) R', and t' <- t' - R^T [t]x w - R^T (step).
  Eigen::Vector3d basis[2];
  PoseModel::tangent(pose.t, basis);
  const Eigen::Matrix3d Rt = pose.R.transpose();
  Eigen::Matrix<double, 6, 5> J = Eigen::Matrix<double, 6, 5>::Zero();
  J.topLeftCorner<3, 3>() = -Rt * crossMatrix(pose.t);
  for (int k = 0; k < 2; ++k) J.block<3, 1>(0, 3 + k) = -Rt * basis[k];
  J.bottomLeftCorner<3, 3>() = -Rt;
  Eigen::Matrix<double, 6, 6> covariance =
      noiseVariance(equations, count, 1) * (J * inverseOf(equations) * J.transpose());
  covariance.topRightCorner<3, 3>().setZero();
  covariance.bottomLeftCorner<3, 3>().setZero();
  return covariance;
}

RotationOnly fitRotationOnly(const PoseModel& model, const PointColumnsView& points, const TwoViewPose& start,
                             const std::vector<float>& inlier_residuals, std::vector<float>& residuals,
                             int64_t& evaluations) {
  constexpr int kIterations = 3;
  RotationOnly result;
  result.R = start.R;
  // From ten pixels at a threshold of one to the threshold's own scale: near points of a translating camera drop out.
  for (float softness : {100.f, 10.f, 2.f}) {
    const Loss loss = {1e12f, 1 / softness};
    evaluations += static_cast<int64_t>(points.count) * model.refineRotation(loss, kIterations, result.R);
  }
  model.rotationResiduals(result.R, residuals.data());
  evaluations += points.count;
  int inliers = 0;
  for (int i = 0; i < points.count; ++i) {
    if (inlier_residuals[static_cast<size_t>(i)] >= 1) continue;
    residuals[static_cast<size_t>(inliers++)] = std::sqrt(residuals[static_cast<size_t>(i)] / points.weight[i]);
  }
  if (inliers > 0) {
    std::nth_element(residuals.begin(), residuals.begin() + inliers / 2, residuals.begin() + inliers);
    result.median_residual = residuals[static_cast<size_t>(inliers / 2)];
  }

  NormalEquations<3> equations;
  model.linearizeRotation(result.R, {kInlierCut, 0}, equations);
  const Eigen::Matrix3d Rt = result.R.transpose();
  result.covariance.bottomRightCorner<3, 3>() =
      noiseVariance(equations, points.count, 2) * (Rt * inverseOf(equations) * result.R);
  // Uniform on the unit sphere has a variance of 1/3 in each coordinate.
  result.covariance.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() / 3;
  return result;
}

}  // namespace gms_ransac
