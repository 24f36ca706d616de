// What the methods share: how an estimate begins (columns, order) and ends (refinement, mask, acceptance, pose), and
// the filters they choose from. A method's own file says in which order they are used.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/method.h"
#include "judgement/inlier_acceptance.h"
#include "judgement/match_noise.h"
#include "judgement/pose_recovery.h"
#include "ransac/ordering.h"
#include "ransac/ransac.h"
#include "ransac/rotation_proposal.h"
#include "two_view/fundamental_model.h"
#include "two_view/homography_model.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

constexpr int kHastyIterations = 3;  ///< of a refinement when time is up

class RansacMethod : public Method {
 public:
  void setSeed(uint64_t seed) override { options_.seed = seed; }
  void setTimeLimit(const TimeLimit* limit) override { ransac_.setTimeLimit(limit); }

 protected:
  explicit RansacMethod(const MatchFilterOptions& options);

  /// Empties the result and takes the pair up; false when there are too few matches for the model.
  bool begin(const PointPairs& pairs, const Camera& camera, RobustResult& result, double noise_exponent = 0);
  /// Puts the matches in the order that samplers count by; until then it is the one given.
  void sort(std::optional<SortKey> key);
  /// The motion with the rotation that another sensor tells; nothing where none does, or the model is no pose. It is
  /// offered when the samples have had their say: what they find and when they stop does not depend on it, so a wrong
  /// prior leaves the answer as it would have been.
  std::optional<Hypothesis> motionOfPrior();
  /// What a sampler is told of a search among so many matches.
  SamplingTask task(int matches, int max_iterations) const;
  /// The robust optimum near the hypothesis.
  Hypothesis refined(const TwoViewModel& model, Hypothesis hypothesis, int iterations);
  /// Whether the search ended so late that what follows must be short; then counted as such.
  bool hurried();
  /// Counts what a refinement cost.
  void countPasses(int passes) { result_->effort.point_evaluations += static_cast<int64_t>(points_.size()) * passes; }

  /// Sets the model from a matrix in working coordinates, and its inliers. False, and no model, when these are not
  /// enough. `ordered`: support among the first of the order counts, too.
  bool accept(const Eigen::Matrix3d& matrix, bool ordered = false);
  /// After that: the pose, if the camera is calibrated, and the probabilities of the matches in any case. `best` is the
  /// accepted hypothesis of `model`.
  void recoverPose(const TwoViewModel& model, const Hypothesis& best, bool refine);

  RobustOptions options_;
  const ResidualKernels& kernels_;
  Random random_;

  // The pair at hand.
  const PointPairs* pairs_ = nullptr;
  const Camera* camera_ = nullptr;
  RobustResult* result_ = nullptr;
  TwoViewPoints points_;
  const TwoViewModel* model_ = nullptr;   ///< the textbook's
  std::vector<int> match_order_, order_;  ///< most confident first: matches, and their columns
  Ransac ransac_;
  MotionStatistics statistics_;  ///< what `filter` returns

 private:
  /// The probabilities of the matches, from nothing but their residuals.
  void weighMatches(const TwoViewModel& model, const Hypothesis& best);

  std::variant<std::monostate, EssentialModel, FundamentalModel, HomographyModel> model_storage_;
  Ordering ordering_;
  RotationProposal rotation_proposal_;
  InlierAcceptance acceptance_;
  PoseRecovery pose_recovery_;
  MatchNoise noise_;
  MatchProbability probability_;
  std::vector<float> residuals_;
};

/// A method whose search alone is its own; what follows on it is the same for all.
class TextbookMethod : public RansacMethod {
 public:
  /// Takes the pair up, searches, refines, judges.
  void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) override;

 protected:
  using RansacMethod::RansacMethod;

  /// The best hypothesis of `model_`; nothing where none was found.
  virtual std::optional<Hypothesis> findBest() = 0;
  /// RANSAC as in the textbook: samples in the order of the matches, every solution of theirs, no local optimisation.
  std::optional<Hypothesis> search(Sampler& sampler, Verifier& verifier);
};

/// A method that keeps all raw matches. Motion statistics are computed only where the user has it sort by them.
class UnfilteredMethod : public TextbookMethod {
 public:
  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override;

 protected:
  explicit UnfilteredMethod(const MatchFilterOptions& options);

 private:
  MotionStatisticsFilter gms_;
  bool wants_scores_;
};

/// A method that estimates from what Grid-based Motion Statistics keep (Bian et al. 2017), with the published settings
/// where the user leaves them open.
class GmsMethod : public TextbookMethod {
 public:
  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override {
    gms_.compute(reference, current, matches, statistics_);
    return statistics_;
  }

 protected:
  explicit GmsMethod(const MatchFilterOptions& options, GridNeighborhood neighborhood = GridNeighborhood::kNine);

  MotionStatisticsFilter gms_;
};

}  // namespace gms_ransac
