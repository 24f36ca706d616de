#include "robust/ransac_estimator.h"

#include <algorithm>
#include <limits>

namespace gms_ransac {

namespace {

QualityKey qualityKey(const Method& method, const RobustOptions& options) {
  if (method.ordering != OrderingChoice::kNone && !options.quality.empty()) return parseQualityKey(options.quality);
  switch (method.ordering) {
    case OrderingChoice::kMotionStatistics:
      return QualityKey::kSupport;
    case OrderingChoice::kDescriptorDistance:
      return QualityKey::kDistance;
    case OrderingChoice::kNone:
      break;
  }
  return QualityKey::kNone;
}

}  // namespace

RansacEstimator::RansacEstimator(const Method& method, const RobustOptions& options)
    : method_(method),
      options_(options),
      quality_key_(qualityKey(method, options)),
      sampler_(makeSampler(method, options)),
      verifier_(method.verifier, options),
      all_points_(options.simd),
      marker_(options.simd),
      pose_recovery_(options.simd) {}

void RansacEstimator::estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  result.clear();
  result.model_type =
      options_.model == ModelType::kEssential && !camera.calibrated() ? ModelType::kFundamental : options_.model;
  result.inlier.assign(static_cast<size_t>(pairs.size()), 0);
  problem_.set(pairs, camera, result.model_type, options_.inlierThreshold());
  if (pairs.size() < problem_.sampleSize()) return;

  random_ = Random(options_.seed);
  ordering_.sort(pairs, quality_key_, order_);
  problem_.arrange(order_, points_);
  // All that sums over the matches does so in an order that has nothing to do with their confidence, as `fast` does.
  strideOver(pairs.size(), arrangement_);
  problem_.arrange(arrangement_, arranged_);
  const Hypothesis best = method_.sampler == SamplerChoice::kRandomSubsets
                              ? searchSubsets(points_, result)
                              : search(points_, options_.max_iterations, result);
  if (best.support.inliers == 0) return;
  result.model = problem_.inResultUnits(refined(best.model, result));
  conclude(pairs, camera, result);
}

RansacEstimator::Hypothesis RansacEstimator::search(const OrderedPoints& points, int max_iterations,
                                                    RobustResult& cost) {
  int sample[kMaxSampleSize];
  Eigen::Matrix3d models[kMaxModels];
  Hypothesis best;
  verifier_.begin(problem_, points);
  marker_.set(problem_, points, 0, points.size());
  sampler_->begin({points.size(), problem_.sampleSize(), options_.confidence, max_iterations});
  while (sampler_->draw(random_, sample)) {
    const int solutions = problem_.solve(points, sample, models);
    ++cost.hypotheses;
    cost.models_scored += solutions;
    for (int i = 0; i < solutions; ++i) {
      const Support support = verifier_.verify(models[i], random_, cost.point_evaluations);
      if (!(best.support < support)) continue;
      best = {models[i], support};
      marker_.mark(best.model, inlier_);
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
  float best_cost = std::numeric_limits<float>::infinity();
  all_points_.set(problem_, arranged_, 0, n);
  for (int s = 0; s < options_.subset_count; ++s) {
    subset_order_ = order_;
    for (int i = 0; i < size; ++i) std::swap(subset_order_[i], subset_order_[i + random_.below(n - i)]);
    subset_order_.resize(static_cast<size_t>(size));
    problem_.arrange(subset_order_, subset_);
    const Hypothesis winner = search(subset_, std::max(1, options_.max_iterations / options_.subset_count), cost);
    if (winner.support.inliers == 0) continue;
    const float winner_cost = all_points_.score(winner.model).cost;
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
  result.model_found = acceptance_.accepts(pairs, problem_.sampleSize(), threshold, result);
  if (!result.model_found) return result.refuse();
  pose_recovery_.recover(pairs, camera, threshold, refines(), result);
}

bool RansacEstimator::refines() const {
  // A method whose inliers are the filter's has the model for the pose's sake alone, so it may as well be a good one.
  return options_.refine || method_.keeps_filter_output;
}

Eigen::Matrix3d RansacEstimator::refined(const Eigen::Matrix3d& model, RobustResult& cost) {
  Eigen::Matrix3d result = model;
  if (!refines() || problem_.type() == ModelType::kEssential) return result;  // that one is refined as a pose
  all_points_.set(problem_, arranged_, 0, arranged_.size());
  cost.point_evaluations += static_cast<int64_t>(points_.size()) * all_points_.refine(result);
  return result;
}

}  // namespace gms_ransac
