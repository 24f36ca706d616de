// `subset_ransac` (Xu 2012): RANSAC inside random subsets, the winner by its cost on all matches. The paper says no
// more than "random subsets on statistical ideas"; this is our reading of it.
#include <algorithm>
#include <limits>
#include <utility>

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

/// Subset size for a meaningful bound from its own inlier ratio.
constexpr int kMatchesPerSampleMember = 20;

class SubsetRansac : public UnfilteredMethod {
 public:
  using UnfilteredMethod::UnfilteredMethod;

  std::optional<Hypothesis> findBest(const PairTask& pair) override {
    const int n = points_.size();
    const int size = prefixLength(options_.subset_fraction, n, kMatchesPerSampleMember * model_->sampleSize());
    all_ = order_;
    std::optional<Hypothesis> best;
    float best_cost = std::numeric_limits<float>::infinity();  // truncated, on all matches (MSAC)
    const auto compare = [&](const std::optional<Hypothesis>& hypothesis) {
      if (!hypothesis) return;
      HypothesisScore score;
      model_->score(points_.view(), *hypothesis, std::numeric_limits<float>::max(), score);
      if (score.cost >= best_cost) return;
      best = hypothesis;
      best_cost = score.cost;
    };
    for (int s = 0; s < options_.subset_count; ++s) {
      order_ = all_;
      for (int i = 0; i < size; ++i) {
        const int other = i + random_.below(n - i);
        std::swap(order_[static_cast<size_t>(i)], order_[static_cast<size_t>(other)]);
      }
      order_.resize(static_cast<size_t>(size));
      compare(searchSubset(std::max(1, options_.max_iterations / options_.subset_count), pair.result.effort));
    }
    compare(motionOfPrior(pair));
    return best;
  }

 private:
  /// RANSAC in the order's matches, with its own bound and an equal share of the samples.
  std::optional<Hypothesis> searchSubset(int max_iterations, Effort& effort) {
    const int size = static_cast<int>(order_.size());
    // Solutions come from all slots, support is counted in the copy of the subset.
    subset_.gather(points_.view(), order_.data(), size);
    CountingVerifier verifier(*model_, subset_.view(), order_);
    sampler_.begin(task(size, max_iterations));
    Ransac ransac(parts(*model_, effort), verifier);
    ransac.search(sampler_);
    return ransac.best();
  }

  std::vector<int> all_;  ///< the order of all matches
  PointColumns subset_;
};

}  // namespace

const MethodEntry kSubsetRansac = {"subset_ransac", "Xu 2012",
                                   "ransac inside random subsets, the winner by its score on all matches", false,
                                   &make<SubsetRansac>};

}  // namespace gms_ransac
