// `lo_prosac`, ours: GMS weighed with descriptors, starts without samples, spread samples of the most distinctive
// matches first (PROSAC), local optimisation (LO-RANSAC), and two refinements. The growth of the prefix, its stop and
// the starts are neither paper's. Choices and their measurements: doc/estimator.md.
#include <limits>
#include <utility>
#include <vector>

#include "gms/cell_grid.h"
#include "judgement/plane_motion.h"
#include "judgement/pose_judge.h"
#include "methods/ransac_method.h"
#include "ransac/motion_starts.h"
#include "ransac/stratified_sampler.h"

namespace gms_ransac {

namespace {

// Noise of a keypoint grows with its pyramid level as scale_factor^(kNoiseExponent * octave). The full 1 of a position
// rounded on its own level overstates it (doc/estimator.md).
constexpr double kNoiseExponent = 0.5;

constexpr int kLocalIterations = 2;
constexpr int kFinalIterations = 10;
/// A pose that leaves more of the matches unexplained is not beyond doubt, and the prior may have chosen it.
constexpr double kMostUnexplained = 1. / 3;
/// Where it does, a share of the matches that the search goes on among, and samples at most.
constexpr double kWideShare = 0.5;
constexpr int kWideSamples = 64;
constexpr float kBetterCost = 0.95f;  ///< of the other's, to replace it as another optimum

class LoProsac : public RansacMethod {
 public:
  explicit LoProsac(const MatchFilterOptions& options)
      : RansacMethod(options),
        gms_(withDefaults(options.motion_statistics, Criterion::kEvidence)),
        judge_(options.robust) {}

  const MotionStatistics& filter(const Features& reference, const Features& current,
                                 const std::vector<Match>& matches) override {
    gms_.compute(reference, current, matches, statistics_);
    return statistics_;
  }

  void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) override {
    const bool enough = begin(pairs, camera, result, kNoiseExponent);
    const std::optional<TwoViewPose> previous = std::exchange(previous_, std::nullopt);
    if (!enough) return;
    sort(SortKey::kLoweRatio);
    sampler_.setCells(order_, points_.cells());
    sampler_.begin(task(points_.size(), options_.max_iterations));
    switch (result.model_type) {
      case ModelType::kEssential:
        return estimatePose(previous);
      case ModelType::kFundamental:
        return estimateMatrix(FundamentalModel(kernels_, points_.view(), true));
      case ModelType::kHomography:
        return estimateMatrix(HomographyModel(kernels_, points_.view(), true));
    }
  }

  void reset() override { previous_.reset(); }

 private:
  void start(const TwoViewModel& model) {
    ransac_.begin(model, points_.view(), order_, verifier_, {kRobustLoss, kLocalIterations}, random_, result_->effort);
  }

  void estimateMatrix(const TwoViewModel& model) {
    start(model);
    ransac_.search(sampler_);
    if (!ransac_.best()) return;
    const Hypothesis answer = refined(model, *ransac_.best(), finalIterations());
    if (accept(model.matrix(answer), true)) recoverPose(model, answer, true);
  }

  void estimatePose(const std::optional<TwoViewPose>& previous) {
    const PoseModel model(kernels_, points_.view(), kParallaxPrior);
    start(model);
    if (previous) offer(*previous);
    offerStarts();
    ransac_.search(sampler_);
    searchWider();
    if (const auto proposal = motionOfPrior()) ransac_.offer(*proposal);
    if (!ransac_.best()) return;
    offerOtherPlaneMotion(model);

    // With the prior of the parallax for the rotation, without it for the model and the direction of translation.
    const PoseModel plain(kernels_, points_.view());
    TwoViewPose pose = refined(model, ransac_.best()->pose);
    TwoViewPose optimum = refined(plain, pose);
    if (!hurried() && leavesMuch(plain, optimum) && findBetter(plain, optimum)) pose = refined(model, optimum);
    judge_.refine(points_, optimum, result_->effort);
    if (!accept(optimum.essential(), true)) return;
    judge_.judge(pose, alternatives_, *result_);
    previous_ = optimum;
  }

  /// The search ends when it is sure of the first matches of the order, which are few where few have survived: a wrong
  /// motion may explain most of them (doc/estimator.md).
  void searchWider() {
    const int left = std::min(kWideSamples, options_.max_iterations - result_->effort.hypotheses);
    if (!ransac_.best() || left <= 0 || hurried()) return;
    if (!leavesMuch(PoseModel(kernels_, points_.view()), ransac_.best()->pose)) return;
    sampler_.begin(task(points_.size(), left), kWideShare);
    ransac_.search(sampler_);
  }

  int finalIterations() { return hurried() ? kHastyIterations : kFinalIterations; }

  using RansacMethod::refined;
  TwoViewPose refined(const PoseModel& model, TwoViewPose pose) {
    countPasses(model.refine(kRobustLoss, finalIterations(), pose, kEnough));
    return pose;
  }

  HypothesisScore scoreOf(const PoseModel& model, const TwoViewPose& pose) {
    HypothesisScore score;
    model.score(points_.view(), pose, std::numeric_limits<float>::max(), score, result_->effort.point_evaluations);
    return score;
  }

  bool leavesMuch(const PoseModel& plain, const TwoViewPose& pose) {
    return scoreOf(plain, pose).inliers < (1 - kMostUnexplained) * points_.size();
  }

  /// Searches once more, without the prior, with the samples that are left; true when that comes to an optimum of less
  /// cost, which `optimum` then is.
  bool findBetter(const PoseModel& plain, TwoViewPose& optimum) {
    const int left = options_.max_iterations - result_->effort.hypotheses;
    if (left <= 0) return false;
    sampler_.begin(task(points_.size(), left));
    start(plain);
    offer(optimum);
    ransac_.search(sampler_);
    if (!ransac_.best()) return false;
    const TwoViewPose other = refined(plain, ransac_.best()->pose);
    if (!(scoreOf(plain, other).cost < kBetterCost * scoreOf(plain, optimum).cost)) return false;
    optimum = other;
    return true;
  }

  void offer(const TwoViewPose& pose) {
    Hypothesis hypothesis;
    hypothesis.pose = pose;
    ransac_.offer(hypothesis);
  }

  /// From directions all over the sphere; they are also the other motions that the answer must beat.
  void offerStarts() {
    findMotionStarts(kernels_, points_.view(), starts_, result_->effort.point_evaluations);
    alternatives_.clear();
    for (const TwoViewPose& motion : starts_) {
      offer(motion);
      alternatives_.push_back({motion});
    }
  }

  /// Where most of the matches lie on a plane, the other motion that explains it (Faugeras & Lustman 1988).
  void offerOtherPlaneMotion(const PoseModel& model) {
    const TwoViewPose best = ransac_.best()->pose;
    int64_t& evaluations = result_->effort.point_evaluations;
    TwoViewPose other;
    if (!findOtherPlaneMotion(points_.view(), best, ransac_.residuals(), other, evaluations)) return;
    float cost;
    other = model.withBetterSign(other, cost, evaluations);
    alternatives_.push_back({best, true});
    alternatives_.push_back({other, true});
    offer(other);
  }

  MotionStatisticsFilter gms_;
  StratifiedSampler sampler_;
  CostVerifier verifier_;
  PoseJudge judge_;
  std::vector<TwoViewPose> starts_;
  std::vector<AlternativeMotion> alternatives_;
  std::optional<TwoViewPose> previous_;  ///< the motion of the last pair
};

}  // namespace

const MethodEntry kLoProsac = {
    "lo_prosac", "this package",
    "GMS, starts from all directions of translation, spread samples of the most distinctive first, refinement", true,
    &make<LoProsac>};

}  // namespace gms_ransac
