// The search of the fast estimator: hypotheses in, best model out, whatever the model.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "gms_ransac/robust_estimator.h"
#include "robust/fast/residual_kernels.h"
#include "robust/fast/stratified_sampler.h"
#include "robust/stopping.h"

namespace gms_ransac {

/// Samples drawn at least. One clean sample is not enough: its model may start the local optimisation in the wrong
/// valley (doc/estimator.md).
constexpr int kMinimumSamples = 8;

/// Local optimisation of every new best: matches up to twice the threshold, weights falling from the threshold on
/// (Geman-McClure). Wide enough to pull a model of five noisy points to the optimum of all.
constexpr Loss kLocalLoss = {4, 1};
constexpr int kLocalIterations = 2;

template <class Model>
class Search {
 public:
  using Hypothesis = typename Model::Hypothesis;

  Search(const Model& model, int count, RobustResult& effort) : model_(model), count_(count), effort_(effort) {}

  /// Scores a hypothesis; a new best one is optimised. True if it became the best.
  bool offer(const Hypothesis& hypothesis) {
    Score score;
    ++effort_.models_scored;
    if (!model_.score(hypothesis, cost_, score, effort_.point_evaluations)) return false;
    keep(hypothesis, score);
    Hypothesis optimized = hypothesis;
    effort_.point_evaluations += static_cast<int64_t>(count_) * model_.refine(kLocalLoss, kLocalIterations, optimized);
    if (model_.score(optimized, cost_, score, effort_.point_evaluations)) keep(optimized, score);
    return true;
  }

  /// Draws samples until, with the confidence asked for, one of them was clean: by the inlier ratio of the matches
  /// that samples come from. `order`: column positions, most confident first; `residuals`: room for all columns.
  void run(const RobustOptions& options, const std::vector<int>& order, StratifiedSampler& sampler,
           std::vector<float>& residuals) {
    Random random(options.seed);
    int sample[Model::kSampleSize];
    Hypothesis hypotheses[Model::kMaxHypotheses];
    if (found()) model_.residuals(best_, residuals.data());
    int required = options.max_iterations, judged_prefix = 0;
    for (int draw = 0; draw < options.max_iterations && draw < std::max(required, kMinimumSamples); ++draw) {
      sampler.draw(random, sample);
      const int count = model_.generate(sample, hypotheses);
      ++effort_.hypotheses;
      bool improved = false;
      for (int h = 0; h < count; ++h) improved = offer(hypotheses[h]) || improved;
      if (improved) model_.residuals(best_, residuals.data());
      if (found() && (improved || sampler.prefix() != judged_prefix)) {
        judged_prefix = sampler.prefix();
        required = bound(options, order, judged_prefix, residuals);
      }
    }
  }

  bool found() const { return cost_ < static_cast<float>(count_); }
  const Hypothesis& best() const { return best_; }
  float cost() const { return cost_; }

 private:
  void keep(const Hypothesis& hypothesis, const Score& score) {
    best_ = hypothesis;
    cost_ = score.cost;
  }

  static int bound(const RobustOptions& options, const std::vector<int>& order, int prefix,
                   const std::vector<float>& residuals) {
    int inliers = 0;
    for (int i = 0; i < prefix; ++i) inliers += residuals[static_cast<size_t>(order[static_cast<size_t>(i)])] < 1;
    return requiredIterations(options.confidence, static_cast<double>(inliers) / std::max(1, prefix),
                              Model::kSampleSize, options.max_iterations);
  }

  const Model& model_;
  int count_;
  RobustResult& effort_;
  Hypothesis best_ = {};
  float cost_ = std::numeric_limits<float>::max();
};

}  // namespace gms_ransac
