#include "ransac/verifier.h"

#include <limits>

#include "ransac/sampler.h"

namespace gms_ransac {

namespace {

constexpr float kNoBound = std::numeric_limits<float>::max();

int countInliers(const TwoViewModel& model, const PointColumnsView& points, const Hypothesis& hypothesis,
                 Effort& effort) {
  HypothesisScore score;
  if (points.count > 0) model.score(points, hypothesis, kNoBound, score, effort.point_evaluations);
  return score.inliers;
}

}  // namespace

void CountingVerifier::begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order) {
  model_ = &model;
  points_ = points;
  order_ = &order;
  best_inliers_ = 0;
}

bool CountingVerifier::beatsBest(const Hypothesis& hypothesis, Random& random, Effort& effort) {
  if (!passesRandomTests(hypothesis, random, effort)) return false;
  const int inliers = countInliers(*model_, points_, hypothesis, effort);
  if (inliers <= best_inliers_) return false;
  best_inliers_ = inliers;
  return true;
}

bool CountingVerifier::passesRandomTests(const Hypothesis& hypothesis, Random& random, Effort& effort) const {
  for (int i = 0; i < tests_; ++i) {
    ++effort.point_evaluations;
    const int rank = random.below(static_cast<int>(order_->size()));
    if (!model_->fits(hypothesis, (*order_)[static_cast<size_t>(rank)])) return false;
  }
  return true;
}

void HoldOutVerifier::begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order) {
  model_ = &model;
  const int n = static_cast<int>(order.size());
  int sampled = prefixLength(fraction_, n, model.sampleSize());
  if (sampled == n) sampled = 0;  // nothing is held out
  sampled_.gather(points, order.data(), sampled);
  held_out_.gather(points, order.data() + sampled, n - sampled);
  best_inliers_ = best_sampled_inliers_ = 0;
}

bool HoldOutVerifier::beatsBest(const Hypothesis& hypothesis, Random& /*random*/, Effort& effort) {
  const int inliers = countInliers(*model_, held_out_.view(), hypothesis, effort);
  const int sampled = countInliers(*model_, sampled_.view(), hypothesis, effort);
  if (inliers < best_inliers_ || (inliers == best_inliers_ && sampled <= best_sampled_inliers_)) return false;
  best_inliers_ = inliers;
  best_sampled_inliers_ = sampled;
  return true;
}

void CostVerifier::begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& /*order*/) {
  model_ = &model;
  points_ = points;
  best_cost_ = static_cast<float>(points.count);
}

bool CostVerifier::beatsBest(const Hypothesis& hypothesis, Random& /*random*/, Effort& effort) {
  HypothesisScore score;
  if (!model_->score(points_, hypothesis, best_cost_, score, effort.point_evaluations)) return false;
  best_cost_ = score.cost;
  return true;
}

}  // namespace gms_ransac
