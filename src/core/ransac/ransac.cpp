#include "ransac/ransac.h"

namespace gms_ransac {

namespace {
constexpr int kFewestSamples = 8;  ///< drawn however late it is: one clean sample may slide into the wrong minimum
}

void Ransac::begin(const TwoViewModel& model, const PointColumnsView& points, const std::vector<int>& order,
                   Verifier& verifier, const LocalOptimization& optimization, Random& random, Effort& effort) {
  model_ = &model;
  points_ = points;
  order_ = &order;
  verifier_ = &verifier;
  optimization_ = optimization;
  random_ = &random;
  effort_ = &effort;
  best_.reset();
  verifier.begin(model, points, order);
}

void Ransac::search(Sampler& sampler) {
  if (best_) tellSampler(sampler);
  const double begin = limit_ != nullptr ? limit_->now() : 0;
  for (int drawn = 1; drawOne(sampler); ++drawn) {
    if (limit_ == nullptr || drawn < kFewestSamples || limit_->now() < limit_->search_until) continue;
    effort_->search_cut = true;
    break;
  }
  if (limit_ != nullptr) effort_->search_seconds += limit_->now() - begin;
}

bool Ransac::drawOne(Sampler& sampler) {
  int sample[kMaxSampleSize];
  Hypothesis hypotheses[kMaxHypotheses];
  if (!sampler.draw(*random_, sample)) return false;
  for (int k = 0; k < model_->sampleSize(); ++k) sample[k] = (*order_)[static_cast<size_t>(sample[k])];
  const int count = model_->solve(sample, hypotheses);
  ++effort_->hypotheses;
  bool improved = false;
  for (int h = 0; h < count; ++h) improved = offer(hypotheses[h]) || improved;
  if (improved) tellSampler(sampler);
  return true;
}

bool Ransac::offer(const Hypothesis& hypothesis) {
  ++effort_->models_scored;
  if (!verifier_->beatsBest(hypothesis, *random_, *effort_)) return false;
  best_ = hypothesis;
  if (optimization_.iterations > 0) {
    Hypothesis optimized = hypothesis;
    const int passes = model_->refine(optimization_.loss, optimization_.iterations, optimized);
    effort_->point_evaluations += static_cast<int64_t>(points_.count) * passes;
    if (verifier_->beatsBest(optimized, *random_, *effort_)) best_ = optimized;
  }
  return true;
}

const std::vector<float>& Ransac::residuals() {
  residuals_.resize(static_cast<size_t>(points_.size));
  model_->residuals(*best_, residuals_.data());
  return residuals_;
}

void Ransac::tellSampler(Sampler& sampler) {
  residuals();
  inlier_.resize(order_->size());
  for (size_t k = 0; k < inlier_.size(); ++k) inlier_[k] = residuals_[static_cast<size_t>((*order_)[k])] < 1;
  sampler.newBest(inlier_);
}

}  // namespace gms_ransac
