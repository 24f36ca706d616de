// `lo_prosac`, ours: GMS weighed with descriptors, starts without samples, spread samples of the most distinctive
// matches first (PROSAC), local optimisation (LO-RANSAC), and two refinements. The growth of the prefix, its stop and
// the starts are neither paper's. Choices and their measurements: doc/measured/constants.md.
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "judgement/pose_judge.h"
#include "methods/optima.h"
#include "methods/ransac_method.h"
#include "ransac/proposals.h"

namespace gms_ransac {

namespace {

// Noise of a keypoint grows with its pyramid level as scale_factor^(kNoiseExponent * octave). The full 1 of a position
// rounded on its own level overstates it (doc/measured/constants.md).
constexpr double kNoiseExponent = 0.5;

constexpr int kLocalIterations = 2;
/// Samples for each match, at most: few matches that agree on nothing are refused in the end, and took longest.
constexpr int kSamplesOfMatch = 5;
/// Samples for a pose, at most: where its starts and so many samples find nothing, more do not
/// (doc/measured/constants.md).
constexpr int kMostPoseSamples = 300;
/// A pose that leaves more of the matches unexplained is not beyond doubt, and the prior may have chosen it.
constexpr double kMostUnexplained = 1. / 3;
/// Where it does, a share of the matches that the search goes on among, and samples at most.
constexpr double kWideShare = 0.5;
constexpr int kWideSamples = 64;

class LoProsac : public RansacMethod {
 public:
  explicit LoProsac(const MatchFilterOptions& options)
      : RansacMethod(options, Criterion::kEvidence), optima_(kernels_), judge_(options.robust) {}

  void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) override {
    const PairTask pair = {pairs, camera, result};
    const bool enough = begin(pair, kNoiseExponent);
    if (!enough) return;
    sort(pairs, SortKey::kLoweRatio);
    sampler_.begin(task(points_.size(), mostSamples()), order_, points_.cells());
    switch (result.model_type) {
      case ModelType::kEssential:
        return estimatePose(pair);
      case ModelType::kFundamental:
        return estimateMatrix(pair, FundamentalModel(kernels_, points_.view(), true));
      case ModelType::kHomography:
        return estimateMatrix(pair, HomographyModel(kernels_, points_.view(), true));
    }
  }

 private:
  /// A search with local optimisation for the least cost.
  struct Search {
    CostVerifier verifier;
    Ransac ransac;

    Search(const SearchParts& parts, const PointColumnsView& points)
        : verifier(parts.model, points), ransac(parts, verifier, {kRobustLoss, kLocalIterations}) {}
    void offer(const TwoViewPose& pose) {
      Hypothesis hypothesis;
      hypothesis.pose = pose;
      ransac.offer(hypothesis);
    }
  };

  void estimateMatrix(const PairTask& pair, const TwoViewModel& model) {
    Search search(parts(model, pair.result.effort), points_.view());
    search.ransac.search(sampler_);
    if (!search.ransac.best()) return;
    Hypothesis answer = *search.ransac.best();
    model.refine(kRobustLoss, finalIterations(pair.result.effort), answer);
    if (accept(pair, model.matrix(answer))) recoverPose(pair, model, answer, true);
  }

  void estimatePose(const PairTask& pair) {
    const PoseModel model(kernels_, points_.view(), kParallaxPrior), plain(kernels_, points_.view());
    Effort& effort = pair.result.effort;
    Search search(parts(model, effort), points_.view());
    const std::optional<Hypothesis>& best = search.ransac.best();
    if (pair.pairs.previous_motion) search.offer(pair.pairs.previous_motion->pose());
    offerStarts(search);
    search.ransac.search(sampler_);
    if (best) searchWider(plain, effort, search);
    if (const auto proposal = motionOfPrior(pair)) search.ransac.offer(*proposal);
    if (!best) return;

    TwoViewPose optimum = optima_.choose(points_, refined(plain, best->pose, effort), starts_);
    weighAligned(plain, optimum);
    optimum = refined(plain, optimum, effort);
    weighAligned(plain, optimum);
    const RefinedPose& answer = judge_.refine(points_, true, optimum);
    if (!accept(pair, answer.pose.essential())) return;
    pair.result.judgement = judge_.judge(answer, optima_.alternatives, options_.mayRoll(pair.pairs.shutter));
    pair.result.optimum = MotionStart(answer.pose);
  }

  /// The search ends when it is sure of the first ranks, which are few where few have survived: a wrong
  /// motion may explain most of them (doc/measured/constants.md).
  void searchWider(const PoseModel& plain, Effort& effort, Search& search) {
    const int left = std::min(kWideSamples, mostSamples() - effort.hypotheses);
    if (left <= 0 || hurried(effort) || !leavesMuch(plain, search.ransac.best()->pose)) return;
    sampler_.begin(task(points_.size(), left), order_, points_.cells(), kWideShare);
    search.ransac.search(sampler_);
  }

  int mostSamples() const {
    const int most = std::min(options_.max_iterations, kSamplesOfMatch * points_.size());
    return points_.type() == ModelType::kEssential ? std::min(most, kMostPoseSamples) : most;
  }

  int finalIterations(Effort& effort) const { return hurried(effort) ? kHastyIterations : kFinalIterations; }

  TwoViewPose refined(const PoseModel& model, TwoViewPose pose, Effort& effort) const {
    model.refine(kRobustLoss, finalIterations(effort), pose, kEnough);
    return pose;
  }

  bool leavesMuch(const PoseModel& plain, const TwoViewPose& pose) const {
    HypothesisScore score;
    plain.score(points_.view(), pose, std::numeric_limits<float>::max(), score);
    return score.inliers < (1 - kMostUnexplained) * points_.size();
  }

  /// From directions all over the sphere.
  void offerStarts(Search& search) {
    findMotionStarts(kernels_, points_.view(), starts_);
    for (const TwoViewPose& motion : starts_) search.offer(motion);
  }

  StratifiedSampler sampler_;
  Optima optima_;
  PoseJudge judge_;
  std::vector<TwoViewPose> starts_;
};

}  // namespace

const MethodEntry kLoProsac = {
    "lo_prosac", "this package",
    "GMS, starts from all directions of translation, spread samples of the most distinctive first, refinement", true,
    &make<LoProsac>};

}  // namespace gms_ransac
