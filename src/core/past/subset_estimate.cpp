#include "past/subset_estimate.h"

#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

void widen(const Eigen::Matrix3d& other, double probability, RelativePose& pose) {
  const Eigen::Vector3d step = rotationVector(other * pose.R.transpose());
  pose.covariance.bottomRightCorner<3, 3>() += probability * step * step.transpose();
}

void SubsetEstimate::estimate(Method& method, const Camera& camera, MatchResult& result) {
  pairs_.gather(result.pairs, rows);
  method.estimate(pairs_, camera, robust);
  result.robust.effort += robust.effort;
}

const std::vector<float>& SubsetEstimate::residuals(const Camera& camera, const PointPairs& all) {
  residual_.resize(static_cast<size_t>(all.size()));
  const bool moves = robust.judgement.translation_observable;
  const Eigen::Matrix3d K = camera.K();
  const Eigen::Matrix3d rotation = K * robust.judgement.pose.R.transpose() * K.inverse();
  const FinalResidual residuals(camera, moves ? robust.model_type : ModelType::kHomography,
                                moves ? robust.model : rotation);
  residuals.forEach(all, [&](size_t row, double squared) {
    // A transfer distance has the noise of both images.
    const double sigma = robust.judgement.sigma(all.octave_current[row], all.scale_factor) * (moves ? 1 : M_SQRT2);
    residual_[row] = static_cast<float>(std::sqrt(squared) / sigma);
  });
  return residual_;
}

void SubsetEstimate::replace(const Camera& camera, MatchResult& result) {
  constexpr float kUnjudged = 0.5f;  // probability of a match that the motion explains and that is not of the subset
  residuals(camera, result.pairs);
  inlier_.assign(residual_.size(), 0);
  probability_.assign(residual_.size(), 0);
  for (size_t row = 0; row < residual_.size(); ++row) {
    if (residual_[row] < kExplained) probability_[row] = kUnjudged;
  }
  for (size_t n = 0; n < rows.size(); ++n) {
    const auto row = static_cast<size_t>(rows[n]);
    inlier_[row] = robust.inlier[n];
    probability_[row] = robust.judgement.probability[n];
    residual_[row] = robust.judgement.residual[n];
  }
  robust.effort = result.robust.effort;
  robust.inlier.swap(inlier_);
  robust.judgement.probability.swap(probability_);
  robust.judgement.residual.swap(residual_);
  std::swap(result.robust, robust);
}

}  // namespace gms_ransac
