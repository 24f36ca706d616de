#include "ransac/ransac.h"

namespace gms_ransac {

namespace {
constexpr int kFewestSamples = 8;  ///< drawn however late it is: one clean sample may slide into the wrong minimum
}

void Ransac::search(Sampler& sampler) {
  const TimeLimit* limit = parts_.limit;
  if (best_) tellSampler(sampler);
  const double begin = limit != nullptr ? limit->now() : 0;
  for (int drawn = 1; drawOne(sampler); ++drawn) {
    if (limit == nullptr || drawn < kFewestSamples || limit->now() < limit->search_until) continue;
    parts_.effort.search_cut = true;
    break;
  }
  if (limit != nullptr) parts_.effort.search_seconds += limit->now() - begin;
}

bool Ransac::drawOne(Sampler& sampler) {
  int sample[kMaxSampleSize];
  Hypothesis hypotheses[kMaxHypotheses];
  if (!sampler.draw(parts_.random, sample)) return false;
  for (int k = 0; k < parts_.model.sampleSize(); ++k) sample[k] = parts_.order[static_cast<size_t>(sample[k])];
  const int count = parts_.model.solve(sample, hypotheses);
  ++parts_.effort.hypotheses;
  bool improved = false;
  for (int h = 0; h < count; ++h) improved = offer(hypotheses[h]) || improved;
  if (improved) tellSampler(sampler);
  return true;
}

bool Ransac::offer(const Hypothesis& hypothesis) {
  ++parts_.effort.models_scored;
  if (!verifier_.beatsBest(hypothesis, parts_.random)) return false;
  best_ = hypothesis;
  if (optimization_.iterations > 0) {
    Hypothesis optimized = hypothesis;
    parts_.model.refine(optimization_.loss, optimization_.iterations, optimized);
    if (verifier_.beatsBest(optimized, parts_.random)) best_ = optimized;
  }
  return true;
}

void Ransac::tellSampler(Sampler& sampler) {
  const std::vector<int>& order = parts_.order;
  std::vector<float>& residuals = parts_.storage.residuals;
  std::vector<uint8_t>& inlier = parts_.storage.inlier;
  parts_.model.residuals(*best_, residuals);
  inlier.resize(order.size());
  for (size_t rank = 0; rank < inlier.size(); ++rank) inlier[rank] = residuals[static_cast<size_t>(order[rank])] < 1;
  sampler.newBest(inlier);
}

}  // namespace gms_ransac
