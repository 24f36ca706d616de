#include "methods/ransac_method.h"

#include <algorithm>
#include <cmath>

#include "gms/cell_grid.h"
#include "judgement/inlier_acceptance.h"
#include "ransac/proposals.h"

namespace gms_ransac {

namespace {

/// Root mean square of a right match's transfer distance, in standard deviations of a coordinate.
constexpr double kTransferSigmas = 2;
/// Iterations for a model found by sampling, which converges in four to eight.
constexpr int kRefinementIterations = 15;

}  // namespace

RansacMethod::RansacMethod(const MatchFilterOptions& options, Criterion criterion)
    : options_(options.robust),
      kernels_(residualKernels(options_.simd)),
      gms_(withDefaults(options.motion_statistics, criterion)),
      pose_recovery_(options_),
      noise_(kernels_) {}

const MotionStatistics& RansacMethod::filter(const Features& reference, const Features& current,
                                             const std::vector<Match>& matches) {
  gms_.compute(reference, current, matches, statistics_);
  return statistics_;
}

bool RansacMethod::begin(const PairTask& pair, double noise_exponent) {
  const auto& [pairs, camera, result] = pair;
  result.clear();
  result.model_type =
      options_.model == ModelType::kEssential && !camera.calibrated() ? ModelType::kFundamental : options_.model;
  result.inlier.assign(static_cast<size_t>(pairs.size()), 0);
  points_.set(pairs, camera, result.model_type, options_.inlierThreshold(), noise_exponent);
  points_.countInto(&result.effort.point_evaluations);
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
  ordering_.sort(pairs, key, order_);
  points_.toSlots(order_);
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
  hypothesis.pose = proposeFromRotation(kernels_, points_.view(), *prior, proposal_storage_);
  hypothesis.matrix = hypothesis.pose.essential();
  if (!hypothesis.matrix.allFinite()) return std::nullopt;
  return hypothesis;
}

void RansacMethod::recoverPose(const PairTask& pair, const TwoViewModel& model, const Hypothesis& best, bool refine) {
  const auto& [pairs, camera, result] = pair;
  weighAligned(model, best);
  const RecoveredPose recovered = pose_recovery_.recover(pairs, camera, points_, result, refine);
  if (recovered.judgement == nullptr) return weighMatches(model, best, result);
  if (recovered.model) setModel(pair, *recovered.model);
  result.judgement = *recovered.judgement;
}

void RansacMethod::weighMatches(const TwoViewModel& model, const Hypothesis& best, RobustResult& result) {
  const PointColumnsView view = points_.view();
  model.residuals(best, storage_.residuals);
  noise_.measure(storage_.residuals, view.count);
  result.judgement.noise_exponent = points_.noiseExponent();
  result.judgement.sigma_px = noise_.sigma() * options_.inlierThreshold();
  const bool on_lines = result.model_type != ModelType::kHomography;
  if (!on_lines) result.judgement.sigma_px /= kTransferSigmas;
  result.judgement.aligned_sigma_px = result.judgement.sigma_px * points_.alignedSigma();
  // A homography says where the point itself belongs, so what is near it needs no further question.
  points_.toRows(on_lines ? noise_.weigh(view, points_.finestWeight()) : noise_.probabilities(),
                 result.judgement.probability);
  points_.toRows(noise_.residuals(), result.judgement.residual);
  noise_.toDeviations(1, result.judgement.residual);
}

void RansacMethod::setModel(const PairTask& pair, const Eigen::Matrix3d& model) const {
  RobustResult& result = pair.result;
  const double threshold = options_.inlierThreshold();
  double sum = 0;
  result.model = model;
  result.inlier.assign(static_cast<size_t>(pair.pairs.size()), 0);
  result.inlier_count = 0;
  FinalResidual(pair.camera, result.model_type, model).forEach(pair.pairs, [&](size_t row, double squared) {
    if (!pair.pairs.hasCoordinates(row) || !(squared < threshold * threshold)) return;
    result.inlier[row] = 1;
    ++result.inlier_count;
    sum += squared;
  });
  result.rms_error_px = result.inlier_count > 0 ? std::sqrt(sum / result.inlier_count) : 0;
}

bool RansacMethod::accept(const PairTask& pair, const Eigen::Matrix3d& matrix) {
  const auto& [pairs, camera, result] = pair;
  setModel(pair, points_.inResultUnits(matrix));
  result.model_found =
      !options_.judge || inliersAreAccepted(pairs, model_->sampleSize(), options_.inlierThreshold(), result, chance_);
  if (!result.model_found) result.reject();
  return result.model_found;
}

void TextbookMethod::estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) {
  const PairTask pair = {pairs, camera, result};
  if (!begin(pair)) return;
  const std::optional<Hypothesis> best = findBest(pair);
  if (best) conclude(pair, *best);
  const bool known = result.model_found && (!camera.calibrated() || result.judgement.translation_observable);
  if (known || !options_.judge || hurried(result.effort)) return;
  if (const auto better = findBetter(pair, best)) conclude(pair, *better);
}

void TextbookMethod::conclude(const PairTask& pair, Hypothesis best) {
  RobustResult& result = pair.result;
  result.reject();
  // A method whose inliers are the filter's has the model for the pose's sake alone, so it may as well be a good one.
  const bool refine = options_.refine || filterDecides();
  if (refine) model_->refine(kRobustLoss, hurried(result.effort) ? kHastyIterations : kRefinementIterations, best);
  if (accept(pair, model_->matrix(best))) recoverPose(pair, *model_, best, refine);
}

UnfilteredMethod::UnfilteredMethod(const MatchFilterOptions& options, const UniformSampler::Options& sampling)
    : TextbookMethod(options, sampling),
      wants_scores_(options_.sort_key == SortKey::kScore || options_.sort_key == SortKey::kRelativeScore) {}

const MotionStatistics& UnfilteredMethod::filter(const Features& reference, const Features& current,
                                                 const std::vector<Match>& matches) {
  if (wants_scores_) {
    RansacMethod::filter(reference, current, matches);
  } else {
    statistics_.score.assign(matches.size(), 0);
    statistics_.relative_score.assign(matches.size(), 0.f);
  }
  statistics_.accepted.assign(matches.size(), 1);
  statistics_.accepted_count = static_cast<int>(matches.size());
  return statistics_;
}

}  // namespace gms_ransac
