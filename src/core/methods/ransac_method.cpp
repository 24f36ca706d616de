#include "methods/ransac_method.h"

#include <algorithm>
#include <numeric>

namespace gms_ransac {

namespace {

/// Root mean square of a right match's transfer distance, in standard deviations of a coordinate.
constexpr double kTransferSigmas = 2;
/// Iterations for a model found by sampling, which converges in four to eight.
constexpr int kRefinementIterations = 15;

}  // namespace

RansacMethod::RansacMethod(const MatchFilterOptions& options)
    : options_(options.robust), kernels_(residualKernels(options_.simd)), pose_recovery_(options_) {}

bool RansacMethod::begin(const PairTask& pair, double noise_exponent) {
  const auto& [pairs, camera, result] = pair;
  result.clear();
  result.model_type =
      options_.model == ModelType::kEssential && !camera.calibrated() ? ModelType::kFundamental : options_.model;
  result.inlier.assign(static_cast<size_t>(pairs.size()), 0);
  points_.set(pairs, camera, result.model_type, options_.inlierThreshold(), noise_exponent);
  points_.countInto(&result.effort.point_evaluations);
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
  sort(pairs, std::nullopt);
  return pairs.size() >= model_->sampleSize();
}

void RansacMethod::sort(const PointPairs& pairs, std::optional<SortKey> key) {
  ordering_.sort(pairs, key, match_order_);
  points_.columnsOf(match_order_, order_);
}

SamplingTask RansacMethod::task(int matches, int max_iterations) const {
  return {matches, model_->sampleSize(), options_.success_probability, max_iterations};
}

bool RansacMethod::hurried(Effort& effort) const {
  if (limit_ == nullptr || !limit_->late()) return false;
  return effort.refinement_cut = true;
}

std::optional<Hypothesis> RansacMethod::motionOfPrior(const PairTask& pair) {
  const std::optional<RotationPrior>& prior = pair.pairs.rotation_prior;
  if (!prior || pair.result.model_type != ModelType::kEssential) return std::nullopt;
  Hypothesis hypothesis;
  hypothesis.pose = rotation_proposal_.find(kernels_, points_.view(), *prior);
  hypothesis.matrix = hypothesis.pose.essential();
  if (!hypothesis.matrix.allFinite()) return std::nullopt;
  return hypothesis;
}

void RansacMethod::recoverPose(const PairTask& pair, const TwoViewModel& model, const Hypothesis& best, bool refine) {
  const auto& [pairs, camera, result] = pair;
  pose_recovery_.recover(pairs, camera, points_, {options_.inlierThreshold(), refine, options_.judge}, result);
  if (!result.pose_found) return weighMatches(model, best, result);
  // The pose of another model than its own is judged with keypoints of all levels alike.
  if (result.model_type != ModelType::kEssential) result.noise_exponent = 0;
}

void RansacMethod::weighMatches(const TwoViewModel& model, const Hypothesis& best, RobustResult& result) {
  const PointColumnsView view = points_.view();
  model.residuals(best, storage_.residuals);
  noise_.measure(storage_.residuals, view.count);
  result.sigma_px = noise_.sigma() * options_.inlierThreshold();
  const bool on_lines = result.model_type != ModelType::kHomography;
  if (!on_lines) result.sigma_px /= kTransferSigmas;
  // A homography says where the point itself belongs, so what is near it needs no further question.
  points_.inOrderOfMatches(
      on_lines ? probability_.weigh(noise_, {}, view, points_.finestWeight()) : noise_.probabilities(),
      result.probability);
  points_.inOrderOfMatches(noise_.residuals(), result.residual);
  noise_.toDeviations(1, result.residual);
}

bool RansacMethod::accept(const PairTask& pair, const Eigen::Matrix3d& matrix, bool ordered) {
  const auto& [pairs, camera, result] = pair;
  result.model = points_.inResultUnits(matrix);
  markFinalInliers(pairs, camera, options_.inlierThreshold(), result);
  result.model_found = !options_.judge || acceptance_.accepts(pairs, model_->sampleSize(), options_.inlierThreshold(),
                                                              result, ordered ? &match_order_ : nullptr);
  if (!result.model_found) result.reject();
  return result.model_found;
}

void TextbookMethod::estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  const PairTask pair = {pairs, camera, result};
  if (!begin(pair)) return;
  std::optional<Hypothesis> best = findBest(pair);
  if (!best) return;
  // A method whose inliers are the filter's has the model for the pose's sake alone, so it may as well be a good one.
  const bool refine = options_.refine || filterDecides();
  if (refine) model_->refine(kRobustLoss, hurried(result.effort) ? kHastyIterations : kRefinementIterations, *best);
  if (accept(pair, model_->matrix(*best))) recoverPose(pair, *model_, *best, refine);
}

std::optional<Hypothesis> TextbookMethod::search(const PairTask& pair, Sampler& sampler, Verifier& verifier) {
  sampler.begin(task(points_.size(), options_.max_iterations));
  Ransac ransac(parts(*model_, pair.result.effort), verifier);
  ransac.search(sampler);
  if (const auto proposal = motionOfPrior(pair)) ransac.offer(*proposal);
  return ransac.best();
}

std::optional<Hypothesis> TextbookMethod::search(const PairTask& pair, Sampler& sampler) {
  CountingVerifier verifier(*model_, points_.view(), order_, tests_);
  return search(pair, sampler, verifier);
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
