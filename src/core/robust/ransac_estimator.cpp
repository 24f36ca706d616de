#include "robust/ransac_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

namespace gms_ransac {

namespace {

QualityKey qualityKey(const Method& method) {
  switch (method.ordering) {
    case OrderingChoice::kMotionStatistics:
      return QualityKey::kScore;
    case OrderingChoice::kDescriptorDistance:
      return QualityKey::kDistance;
    case OrderingChoice::kNone:
      break;
  }
  return QualityKey::kNone;
}

/// True when the inliers of one image lie on a line (or in a point) up to the threshold: such matches fit a whole
/// family of models, and the one found means nothing.
bool collinear(const std::vector<float>& x, const std::vector<float>& y, const std::vector<uint8_t>& inlier,
               double threshold_px) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double n = 0;
  for (size_t i = 0; i < inlier.size(); ++i) {
    if (!inlier[i]) continue;
    sum += Eigen::Vector2d(x[i], y[i]);
    ++n;
  }
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (size_t i = 0; i < inlier.size(); ++i) {
    if (!inlier[i]) continue;
    const Eigen::Vector2d d = Eigen::Vector2d(x[i], y[i]) - sum / n;
    scatter += d * d.transpose();
  }
  const double half_trace = 0.5 * scatter.trace();
  const double smaller = half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - scatter.determinant()));
  return smaller < n * threshold_px * threshold_px;
}

}  // namespace

RansacEstimator::RansacEstimator(const Method& method, const RobustOptions& options)
    : method_(method), options_(options), sampler_(makeSampler(method, options)), verifier_(method.verifier, options) {}

void RansacEstimator::estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  result.clear();
  result.model_type =
      options_.model == ModelType::kEssential && !camera.calibrated() ? ModelType::kFundamental : options_.model;
  result.inlier.assign(static_cast<size_t>(pairs.size()), 0);
  problem_.set(pairs, camera, result.model_type, options_.inlierThreshold());
  if (pairs.size() < problem_.sampleSize()) return;

  random_ = Random(options_.seed);
  ordering_.sort(pairs, qualityKey(method_), order_);
  problem_.arrange(order_, points_);
  const Hypothesis best = method_.sampler == SamplerChoice::kRandomSubsets
                              ? searchSubsets(points_, result)
                              : search(points_, options_.max_iterations, result);
  if (best.support.inliers == 0) return;
  result.model = problem_.inResultUnits(best.model);
  conclude(pairs, camera, result);
}

RansacEstimator::Hypothesis RansacEstimator::search(const OrderedPoints& points, int max_iterations,
                                                    RobustResult& cost) {
  int sample[kMaxSampleSize];
  Eigen::Matrix3d models[kMaxModels];
  Hypothesis best;
  inlier_.resize(static_cast<size_t>(points.size()));
  sampler_->begin({points.size(), problem_.sampleSize(), options_.confidence, max_iterations});
  while (sampler_->draw(random_, sample)) {
    const int solutions = problem_.solve(points, sample, models);
    ++cost.hypotheses;
    cost.models_scored += solutions;
    for (int i = 0; i < solutions; ++i) {
      const Support support = verifier_.verify(problem_, points, models[i], random_, cost.point_evaluations);
      if (!(best.support < support)) continue;
      best = {models[i], support};
      problem_.markInliers(best.model, points, 0, points.size(), inlier_.data());
      sampler_->improve(inlier_);
    }
  }
  return best;
}

RansacEstimator::Hypothesis RansacEstimator::searchSubsets(const OrderedPoints& points, RobustResult& cost) {
  // Large enough that a bound from the subset's own inlier ratio means something (algorithms of the field ask for about
  // twenty times the sample).
  constexpr int kMatchesPerSampleMember = 20;
  const int n = points.size();
  const int size = prefixLength(options_.subset_fraction, n, kMatchesPerSampleMember * problem_.sampleSize());
  Hypothesis best;
  double best_cost = std::numeric_limits<double>::infinity();
  subset_order_ = order_;
  for (int s = 0; s < options_.subset_count; ++s) {
    for (int i = 0; i < size; ++i) std::swap(subset_order_[i], subset_order_[i + random_.below(n - i)]);
    subset_order_.resize(static_cast<size_t>(size));
    problem_.arrange(subset_order_, subset_);
    subset_order_ = order_;
    const Hypothesis winner = search(subset_, std::max(1, options_.max_iterations / options_.subset_count), cost);
    if (winner.support.inliers == 0) continue;
    const double winner_cost = problem_.truncatedCost(winner.model, points);
    cost.point_evaluations += n;
    if (winner_cost >= best_cost) continue;
    best = winner;
    best_cost = winner_cost;
  }
  return best;
}

void RansacEstimator::conclude(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  const double threshold = options_.inlierThreshold();
  markFinalInliers(pairs, camera, threshold, result);
  chance_.setSampleSize(problem_.sampleSize());
  result.model_found = result.inlier_count >= chance_.minimum(pairs.size()) &&
                       !collinear(pairs.x_reference, pairs.y_reference, result.inlier, threshold) &&
                       !collinear(pairs.x_current, pairs.y_current, result.inlier, threshold);
  if (!result.model_found) {
    std::fill(result.inlier.begin(), result.inlier.end(), 0);
    result.inlier_count = 0;
    result.rms_error_px = 0;
    return;
  }
  pose_recovery_.recover(pairs, camera, result);
}

}  // namespace gms_ransac
