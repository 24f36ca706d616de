// The parts that methods share: begin (points, order) and end (refinement, mask, acceptance, pose) of an estimate, and
// filters.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "gms_ransac/match_filter_options.h"
#include "judgement/match_noise.h"
#include "methods/method.h"
#include "methods/pose_recovery.h"
#include "ransac/ordering.h"
#include "ransac/ransac.h"
#include "two_view/matrix_models.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

constexpr int kHastyIterations = 3;  ///< of a refinement when time is up

/// A pair and what is to be said of it.
struct PairTask {
  const PointPairs& pairs;
  const Camera& camera;
  RobustResult& result;
};

class RansacMethod : public Method {
 public:
  /// Grid-based Motion Statistics (Bian et al. 2017).
  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override;
  void setSeed(uint64_t seed) override { options_.seed = seed; }
  void setTimeLimit(const TimeLimit* limit) override { limit_ = limit; }

 protected:
  /// `criterion`: of the filter, unless the user has another; the published one by default.
  explicit RansacMethod(const MatchFilterOptions& options, Criterion criterion = Criterion::kThreshold);

  /// Empties the result and fills the points; false when there are too few matches for the model.
  bool begin(const PairTask& pair, double noise_exponent = 0);
  /// Gives the matches their ranks; until then these are the rows.
  void sort(const PointPairs& pairs, std::optional<SortKey> key);
  /// The motion with another sensor's rotation, if there is one and the model is a pose. Offered after the samples, so
  /// that a wrong prior changes nothing.
  std::optional<Hypothesis> motionOfPrior(const PairTask& pair);
  SamplingTask task(int matches, int max_iterations) const;
  SearchParts parts(const TwoViewModel& model, Effort& effort) {
    return {model, order_, random_, effort, limit_, storage_};
  }
  /// True if the search ended so late that refinement must be short; noted in the effort.
  bool hurried(Effort& effort) const;

  /// Weighs the aligned points by what a motion or a hypothesis of the model leaves of them.
  template <class Model, class Answer>
  void weighAligned(const Model& model, const Answer& answer) {
    model.residuals(answer, storage_.residuals);
    points_.weighAligned(storage_.residuals);
  }
  /// Sets model and inliers from a matrix in working coordinates; false, and no model, if they are too few.
  bool accept(const PairTask& pair, const Eigen::Matrix3d& matrix);
  /// Finds the pose, if the camera is calibrated, and the probabilities of the matches for the accepted `best`.
  void recoverPose(const PairTask& pair, const TwoViewModel& model, const Hypothesis& best, bool refine);

  RobustOptions options_;
  const ResidualKernels& kernels_;
  const TimeLimit* limit_ = nullptr;  ///< null: none
  Random random_;
  TwoViewPoints points_;
  const TwoViewModel* model_ = nullptr;  ///< the textbook's, of these points
  std::vector<int> order_;               ///< slots by rank, most confident first
  SearchStorage storage_;
  MotionStatisticsFilter gms_;
  MotionStatistics statistics_;  ///< what `filter` returns

 private:
  /// Sets the model and, in double precision, its inliers.
  void setModel(const PairTask& pair, const Eigen::Matrix3d& model) const;
  void weighMatches(const TwoViewModel& model, const Hypothesis& best, RobustResult& result);

  std::variant<std::monostate, EssentialModel, FundamentalModel, HomographyModel> model_storage_;
  Ordering ordering_;
  PointColumns proposal_storage_;
  ChanceSupport chance_;
  PoseRecovery pose_recovery_;
  MatchNoise noise_;
};

/// A method whose search alone is its own; what follows on it is the same for all.
class TextbookMethod : public RansacMethod {
 public:
  explicit TextbookMethod(const MatchFilterOptions& options, const UniformSampler::Options& sampling = {})
      : RansacMethod(options), sampler_(sampling), tests_(sampling.extra_tests) {}
  void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) override;

 protected:
  /// The best hypothesis of `model_`; by uniform samples unless a method has its own.
  virtual std::optional<Hypothesis> findBest(const PairTask& pair) { return search(pair, sampler_); }
  /// A better one than `best`, where the judgement of that one refuses it or its direction; by default there is none.
  virtual std::optional<Hypothesis> findBetter(const PairTask& /*pair*/, const std::optional<Hypothesis>& /*best*/) {
    return std::nullopt;
  }
  /// RANSAC as in the textbook: samples by rank, every solution of theirs, no local optimisation.
  template <class SomeSampler>
  std::optional<Hypothesis> search(const PairTask& pair, SomeSampler& sampler, Verifier& verifier) {
    sampler.begin(task(points_.size(), options_.max_iterations));
    Ransac ransac(parts(*model_, pair.result.effort), verifier);
    ransac.search(sampler);
    if (const auto proposal = motionOfPrior(pair)) ransac.offer(*proposal);
    return ransac.best();
  }
  /// Verified by the inliers among all matches.
  template <class SomeSampler>
  std::optional<Hypothesis> search(const PairTask& pair, SomeSampler& sampler) {
    CountingVerifier verifier(*model_, points_.view(), order_, tests_);
    return search(pair, sampler, verifier);
  }

  UniformSampler sampler_;
  int tests_;  ///< d of the T(d,d) test

 private:
  /// Refines a hypothesis and judges it.
  void conclude(const PairTask& pair, Hypothesis best);
};

/// A method that keeps all raw matches. Motion statistics are computed only where the user has it sort by them.
class UnfilteredMethod : public TextbookMethod {
 public:
  explicit UnfilteredMethod(const MatchFilterOptions& options, const UniformSampler::Options& sampling = {});
  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override;

 private:
  bool wants_scores_;
};

}  // namespace gms_ransac
