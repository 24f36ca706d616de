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

  std::optional<Hypothesis> findBest() override {
    const int n = points_.size();
    const int size = prefixLength(options_.subset_fraction, n, kMatchesPerSampleMember * model_->sampleSize());
    best_.reset();
    best_cost_ = std::numeric_limits<float>::infinity();
    for (int s = 0; s < options_.subset_count; ++s) {
      drawSubset(size);
      compare(searchSubset(std::max(1, options_.max_iterations / options_.subset_count)));
    }
    compare(motionOfPrior());
    return best_;
  }

 private:
  void drawSubset(int size) {
    subset_ = order_;
    const int n = static_cast<int>(subset_.size());
    for (int i = 0; i < size; ++i) {
      const int other = i + random_.below(n - i);
      std::swap(subset_[static_cast<size_t>(i)], subset_[static_cast<size_t>(other)]);
    }
    subset_.resize(static_cast<size_t>(size));
  }

  /// RANSAC with its own bound and an equal share of the samples.
  std::optional<Hypothesis> searchSubset(int max_iterations) {
    columns_.gather(points_.view(), subset_.data(), static_cast<int>(subset_.size()));
    sampler_.begin(task(static_cast<int>(subset_.size()), max_iterations));
    // Solutions come from all columns, support is counted in the copy of the subset.
    ransac_.begin(*model_, points_.view(), subset_, verifier_, {}, random_, result_->effort);
    verifier_.begin(*model_, columns_.view(), subset_);
    ransac_.search(sampler_);
    return ransac_.best();
  }

  void compare(const std::optional<Hypothesis>& hypothesis) {
    if (!hypothesis) return;
    HypothesisScore score;
    model_->score(points_.view(), *hypothesis, std::numeric_limits<float>::max(), score,
                  result_->effort.point_evaluations);
    if (score.cost >= best_cost_) return;
    best_ = hypothesis;
    best_cost_ = score.cost;
  }

  std::vector<int> subset_;
  PointColumns columns_;  ///< of the subset
  std::optional<Hypothesis> best_;
  float best_cost_ = 0;  ///< truncated, on all matches (MSAC)
};

}  // namespace

const MethodEntry kSubsetRansac = {"subset_ransac", "Xu 2012",
                                   "ransac inside random subsets, the winner by its score on all matches", false,
                                   &make<SubsetRansac>};

}  // namespace gms_ransac
