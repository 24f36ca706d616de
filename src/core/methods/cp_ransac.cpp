// `cp_ransac`: the method of the paper that this package implements, Section III. Features and matches come in (ORB,
// brute force); what follows is here from top to bottom.
#include "methods/cp_ransac.h"

#include "methods/ransac_method.h"

namespace gms_ransac {

namespace {

/// Smallest share of the matches that forms a group of its own.
constexpr double kSmallestRest = 0.05;

class CpRansac : public TextbookMethod {
 public:
  explicit CpRansac(const MatchFilterOptions& options)
      : TextbookMethod(options), groups_(options.robust.first_group_fraction, options.robust.geometric_groups) {}

  // "a coarse screening using the GMS algorithm": RansacMethod::filter.

  std::optional<Hypothesis> findBest(const PairTask& pair) override {
    // "sorting and grouping the matching pairs based on their neighborhood scores". Here by score over threshold: the
    // bare score (`sort_key: score`) gathers the samples in the densest texture and costs three points of AUC on
    // kitti_06.
    sort(pair.pairs, options_.sort_key.value_or(SortKey::kRelativeScore));
    // "The pairs with higher neighborhood scores are given priority as the initial set for solving the optimal model".
    // All survivors judge a hypothesis, whichever group it came from.
    return search(pair, groups_);
  }

  /// Crowded matches may agree on a motion that is not that of all, and the group's bound does not notice. So what is
  /// judged to be unknown is searched on among all survivors, up to their bound, for which all samples count. The paper
  /// judges no model.
  std::optional<Hypothesis> findBetter(const PairTask& pair, const std::optional<Hypothesis>& best) override {
    CountingVerifier verifier(*model_, points_.view(), order_);
    Ransac ransac(parts(*model_, pair.result.effort), verifier);
    if (best) ransac.offer(*best);
    sampler_.begin(task(points_.size(), options_.max_iterations), pair.result.effort.hypotheses);
    ransac.search(sampler_);
    const bool is_better = ransac.best() && (!best || ransac.best()->matrix != best->matrix);
    return is_better ? ransac.best() : std::nullopt;
  }

 private:
  ConfidenceGroupSampler groups_;
};

}  // namespace

/// First group: share `first_fraction` of the matches; then all, or with `geometric` that share of the rest, and so on.
void ConfidenceGroupSampler::begin(const SamplingTask& task) {
  task_ = task;
  groups_.clear();
  double covered = first_fraction_;
  while (covered < 1 - kSmallestRest) {
    groups_.push_back({prefixLength(covered, task.matches, task.sample_size), task.max_iterations});
    covered = geometric_ ? covered + first_fraction_ * (1 - covered) : 1;
  }
  groups_.push_back({task.matches, task.max_iterations});
  phase_ = 0;
  drawn_ = drawn_in_phase_ = 0;
  supported_ = false;
}

bool ConfidenceGroupSampler::phaseFailed() const {
  if (phase_ + 1 == groups_.size()) return false;
  const int drawn_before = drawn_ - drawn_in_phase_;
  const int budget = (task_.max_iterations - drawn_before) / 2;
  return drawn_in_phase_ >= budget || groups_[phase_].bound > groups_[phase_ + 1].bound;
}

bool ConfidenceGroupSampler::draw(Random& random, int* sample) {
  if (drawn_ >= task_.max_iterations) return false;
  if (supported_ && drawn_in_phase_ >= groups_[phase_].bound) return false;
  while (phaseFailed()) {
    ++phase_;
    drawn_in_phase_ = 0;
  }
  ++drawn_;
  ++drawn_in_phase_;
  drawDistinct(random, groups_[phase_].size, task_.sample_size, sample);
  return true;
}

void ConfidenceGroupSampler::newBest(const std::vector<uint8_t>& inlier) {
  int inliers = 0;
  for (Group& group : groups_) {
    inliers = countPrefix(inlier, group.size);
    const double ratio = static_cast<double>(inliers) / group.size;  // t of equation (1)
    // Equation (3), for the group that samples come from: "until the desired precision is achieved".
    group.bound = requiredIterations(task_.success_probability, ratio, task_.sample_size, task_.max_iterations);
  }
  supported_ = inliers >= chance_.minimum(task_.sample_size, task_.matches);
}

const MethodEntry kCpRansac = {"cp_ransac", "the paper this package implements",
                               "GMS, survivors sorted by neighbourhood support, samples from the most confident group "
                               "first",
                               true, &make<CpRansac>};

}  // namespace gms_ransac
