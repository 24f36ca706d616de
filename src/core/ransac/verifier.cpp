#include "ransac/verifier.h"

#include <limits>

#include "ransac/sampler.h"

namespace gms_ransac {

namespace {

int countInliers(const TwoViewModel& model, const PointColumnsView& points, const Hypothesis& hypothesis) {
  HypothesisScore score;
  if (points.count > 0) model.score(points, hypothesis, std::numeric_limits<float>::max(), score);
  return score.inliers;
}

}  // namespace

bool CountingVerifier::beatsBest(const Hypothesis& hypothesis, Random& random) {
  if (!passesRandomTests(hypothesis, random)) return false;
  const int inliers = countInliers(model_, points_, hypothesis);
  if (inliers <= best_inliers_) return false;
  best_inliers_ = inliers;
  return true;
}

bool CountingVerifier::passesRandomTests(const Hypothesis& hypothesis, Random& random) const {
  for (int i = 0; i < tests_; ++i) {
    const int rank = random.below(static_cast<int>(order_.size()));
    if (!model_.fits(hypothesis, order_[static_cast<size_t>(rank)])) return false;
  }
  return true;
}

HoldOutVerifier::HoldOutVerifier(const TwoViewModel& model, const PointColumnsView& points,
                                 const std::vector<int>& order, double fraction)
    : model_(model) {
  const int n = static_cast<int>(order.size());
  int sampled = prefixLength(fraction, n, model.sampleSize());
  if (sampled == n) sampled = 0;  // nothing is held out
  sampled_.gather(points, order.data(), sampled);
  held_out_.gather(points, order.data() + sampled, n - sampled);
}

bool HoldOutVerifier::beatsBest(const Hypothesis& hypothesis, Random& /*random*/) {
  const int inliers = countInliers(model_, held_out_.view(), hypothesis);
  const int sampled = countInliers(model_, sampled_.view(), hypothesis);
  if (inliers < best_inliers_ || (inliers == best_inliers_ && sampled <= best_sampled_inliers_)) return false;
  best_inliers_ = inliers;
  best_sampled_inliers_ = sampled;
  return true;
}

bool CostVerifier::beatsBest(const Hypothesis& hypothesis, Random& /*random*/) {
  HypothesisScore score;
  if (!model_.score(points_, hypothesis, best_cost_, score)) return false;
  best_cost_ = score.cost;
  return true;
}

}  // namespace gms_ransac
