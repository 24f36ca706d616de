#include "methods/ransac_method.h"

#include <algorithm>
#include <numeric>

#include "judgement/pose_recovery.h"

namespace gms_ransac {

namespace {

/// Root mean square of a right match's transfer distance, in standard deviations of a coordinate.
constexpr double kTransferSigmas = 2;
/// Iterations for a model found by sampling, which converges in four to eight.
constexpr int kRefinementIterations = 15;

}  // namespace

RansacMethod::RansacMethod(const MatchFilterOptions& options)
    : options_(options.robust),
      kernels_(residualKernels(options_.simd)),
      pose_recovery_(std::make_unique<PoseRecovery>(options_)) {}

RansacMethod::~RansacMethod() = default;

bool RansacMethod::begin(const PointPairs& pairs, const Camera& camera, RobustResult& result, double noise_exponent) {
  pairs_ = &pairs;
  camera_ = &camera;
  result_ = &result;
  result.clear();
  result.model_type =
      options_.model == ModelType::kEssential && !camera.calibrated() ? ModelType::kFundamental : options_.model;
  result.inlier.assign(static_cast<size_t>(pairs.size()), 0);
  points_.set(pairs, camera, result.model_type, options_.inlierThreshold(), noise_exponent);
  result.noise_exponent = noise_exponent;
  switch (result.model_type) {
    case ModelType::kEssential:
      model_ = &model_storage_.emplace<EssentialModel>(kernels_, points_.view());
      break;
    case ModelType::kFundamental:
      model_ = &model_storage_.emplace<FundamentalModel>(kernels_, points_.view(), false);
      break;
    case ModelType::kHomography:
      model_ = &model_storage_.emplace<HomographyModel>(kernels_, points_.view(), false);
      break;
  }
  random_ = Random(options_.seed);
  sort(std::nullopt);
  return pairs.size() >= model_->sampleSize();
}

void RansacMethod::sort(std::optional<SortKey> key) {
  ordering_.sort(*pairs_, key, match_order_);
  points_.columnsOf(match_order_, order_);
}

SamplingTask RansacMethod::task(int matches, int max_iterations) const {
  return {matches, model_->sampleSize(), options_.success_probability, max_iterations};
}

bool RansacMethod::hurried() {
  if (!ransac_.late()) return false;
  return result_->effort.refinement_cut = true;
}

Hypothesis RansacMethod::refined(const TwoViewModel& model, Hypothesis hypothesis, int iterations) {
  countPasses(model.refine(kRobustLoss, iterations, hypothesis));
  return hypothesis;
}

std::optional<Hypothesis> RansacMethod::motionOfPrior() {
  const std::optional<RotationPrior>& prior = pairs_->rotation_prior;
  if (!prior || result_->model_type != ModelType::kEssential) return std::nullopt;
  Hypothesis hypothesis;
  hypothesis.pose = rotation_proposal_.find(kernels_, points_.view(), *prior, result_->effort.point_evaluations);
  hypothesis.matrix = hypothesis.pose.essential();
  if (!hypothesis.matrix.allFinite()) return std::nullopt;
  return hypothesis;
}

void RansacMethod::recoverPose(const TwoViewModel& model, const Hypothesis& best, bool refine) {
  pose_recovery_->recover(*pairs_, *camera_, points_, {options_.inlierThreshold(), refine, options_.judge}, *result_);
  if (!result_->pose_found) return weighMatches(model, best);
  // The pose of another model than its own is judged with keypoints of all levels alike.
  if (result_->model_type != ModelType::kEssential) result_->noise_exponent = 0;
}

void RansacMethod::weighMatches(const TwoViewModel& model, const Hypothesis& best) {
  const PointColumnsView view = points_.view();
  residuals_.resize(static_cast<size_t>(view.size));
  model.residuals(best, residuals_.data());
  noise_.measure(residuals_, view.count);
  result_->sigma_px = noise_.sigma() * options_.inlierThreshold();
  const bool on_lines = result_->model_type != ModelType::kHomography;
  if (!on_lines) result_->sigma_px /= kTransferSigmas;
  // A homography says where the point itself belongs, so what is near it needs no further question.
  points_.inOrderOfMatches(on_lines ? probability_.weigh(noise_, view, points_.finestWeight()) : noise_.probabilities(),
                           result_->probability);
  points_.inOrderOfMatches(noise_.residuals(), result_->residual);
  noise_.toDeviations(1, result_->residual);
}

bool RansacMethod::accept(const Eigen::Matrix3d& matrix, bool ordered) {
  result_->model = points_.inResultUnits(matrix);
  markFinalInliers(*pairs_, *camera_, options_.inlierThreshold(), *result_);
  result_->model_found =
      !options_.judge || acceptance_.accepts(*pairs_, model_->sampleSize(), options_.inlierThreshold(), *result_,
                                             ordered ? &match_order_ : nullptr);
  if (!result_->model_found) result_->reject();
  return result_->model_found;
}

void TextbookMethod::estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  if (!begin(pairs, camera, result)) return;
  const std::optional<Hypothesis> best = findBest();
  if (!best) return;
  // A method whose inliers are the filter's has the model for the pose's sake alone, so it may as well be a good one.
  const bool refine = options_.refine || filterDecides();
  const Hypothesis answer =
      refine ? refined(*model_, *best, hurried() ? kHastyIterations : kRefinementIterations) : *best;
  if (accept(model_->matrix(answer))) recoverPose(*model_, answer, refine);
}

std::optional<Hypothesis> TextbookMethod::search(Sampler& sampler, Verifier& verifier) {
  sampler.begin(task(points_.size(), options_.max_iterations));
  ransac_.begin(*model_, points_.view(), order_, verifier, {}, random_, result_->effort);
  ransac_.search(sampler);
  if (const auto proposal = motionOfPrior()) ransac_.offer(*proposal);
  return ransac_.best();
}

UnfilteredMethod::UnfilteredMethod(const MatchFilterOptions& options, const UniformSampler::Options& sampling,
                                   int tests)
    : TextbookMethod(options, sampling, tests),
      gms_(options.motion_statistics),
      wants_scores_(options_.sort_key == SortKey::kScore || options_.sort_key == SortKey::kRelativeScore) {}

const MotionStatistics& UnfilteredMethod::filter(const Features& reference, const Features& current,
                                                 const std::vector<Match>& matches) {
  if (wants_scores_) {
    gms_.compute(reference, current, matches, statistics_);
  } else {
    statistics_.score.assign(matches.size(), 0);
    statistics_.relative_score.assign(matches.size(), 0.f);
  }
  statistics_.accepted.assign(matches.size(), 1);
  statistics_.accepted_count = static_cast<int>(matches.size());
  return statistics_;
}

}  // namespace gms_ransac
