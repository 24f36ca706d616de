// The pipeline, stage by stage.
#include "gms_ransac/match_filter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <opencv2/core.hpp>

#include "gms/guided_search.h"
#include "gms/motion_prediction.h"
#include "match_filter_hooks.h"
#include "matching/any_matcher.h"
#include "matching/repetition.h"
#include "methods/method.h"
#include "parameters/parameter.h"
#include "past/continuity.h"
#include "past/fixed_to_camera.h"
#include "past/standstill.h"
#include "support/time_budget.h"
#include "survivors.h"
#include "tracks/track_table.h"

namespace gms_ransac {

namespace {

class StopWatch {
 public:
  explicit StopWatch(const Clock& clock) : clock_(clock), last_(clock()) {}
  double lap() {
    const double before = std::exchange(last_, clock_());
    return last_ - before;
  }

 private:
  const Clock& clock_;
  double last_;
};

double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

HammingMatcherOptions matcherOptions(const MatchFilterOptions& options, const Method& method) {
  HammingMatcherOptions matcher;
  matcher.mutual = method.wantsMutualMatches();
  matcher.threads = options.matcher_threads;
  return matcher;
}

void recordCost(const Frame& reference, const Frame& current, const MatchResult& result, TimeBudget& budget) {
  PairCost cost;
  cost.pixels = current.features.image_size.area();
  cost.asked = current.features_asked;
  cost.reference = reference.features.size();
  cost.current = current.features.size();
  cost.before = current.seconds_before;
  cost.extract = current.detect_seconds;
  cost.match = result.times.match;
  cost.filter = result.times.gms;
  cost.search = result.robust.effort.search_seconds;
  cost.estimate = result.times.ransac - cost.search;
  budget.record(cost);
}

}  // namespace

MatchFilterOptions MatchFilterOptions::paper() {
  MatchFilterOptions options;
  options.method = "cp_ransac";
  options.extractor.extractor = "opencv";
  options.search = SearchMode::kFull;
  options.one_to_one = false;
  options.robust.sort_key = SortKey::kScore;
  options.robust.first_group_fraction = 0.5;
  options.robust.refine = options.robust.judge = false;
  return options;
}

/// Each stage keeps nothing but storage from pair to pair.
struct MatchFilter::Stages {
  explicit Stages(const MatchFilterOptions& options)
      : method(makeMethod(options)),
        extractor(makeFeatureExtractor(options.extractor)),
        matcher(matcherOptions(options, *method)),
        selector(options.one_to_one, options.robust.rolling_shutter_readout > 0),
        repetition(options.robust.simd) {
    // A filter that decides alone would take every match that agrees with the predicted motion for an inlier.
    if (options.search == SearchMode::kGuided && !method->wantsMutualMatches() && !method->filterDecides()) {
      guided_search.emplace(matcherOptions(options, *method), options.motion_statistics);
    }
  }

  Clock clock = steadySeconds;
  Camera camera;
  std::unique_ptr<Method> method;
  std::unique_ptr<FeatureExtractor> extractor;
  HammingMatcher matcher;
  std::optional<GuidedSearch> guided_search;  ///< replaces the matcher
  MotionPrediction rotation_prediction;
  SurvivorSelector selector;
  Repetition repetition;
  FixedToCamera fixed_to_camera;
  Continuity continuity;
  TrackTable tracks;                   ///< of the sequence that is given to `process`
  std::shared_ptr<TimeBudget> budget;  ///< null: no limit
};

MatchFilter::MatchFilter(const MatchFilterOptions& options)
    : options_(options), stages_(std::make_unique<Stages>(options)) {
  setClock(steadySeconds);
}

MatchFilter::~MatchFilter() = default;
MatchFilter::MatchFilter(MatchFilter&&) noexcept = default;
MatchFilter& MatchFilter::operator=(MatchFilter&&) noexcept = default;

const Camera& MatchFilter::camera() const { return stages_->camera; }

void MatchFilter::setCamera(const Camera& camera) {
  if (stages_->camera != camera) stages_->camera = camera;
}

void MatchFilter::reset() {
  have_reference_ = have_current_ = false;
  reference_ = Frame();
  past_ = Past();
  stages_->tracks.reset();
}

void MatchFilter::requireCameraSize(const cv::Size& image) const {
  const cv::Size camera = stages_->camera.imageSize();
  if (camera.empty() || image == camera) return;
  throw std::invalid_argument(
      cv::format("MatchFilter: the image is %d x %d pixels, the camera %d x %d; set the camera "
                 "of these images",
                 image.width, image.height, camera.width, camera.height));
}

const MatchResult& MatchFilter::process(const cv::Mat& image, const cv::Mat& mask, std::optional<double> stamp,
                                        const RotationPrior* prior) {
  requireCameraSize(image.size());
  extract(image, nextFrame(), mask, stamp);
  return compareWithLast(prior);
}

const MatchResult& MatchFilter::process(Features features, std::optional<double> stamp, const RotationPrior* prior) {
  features.validate();
  requireCameraSize(features.image_size);
  nextFrame() = Frame(std::move(features), stamp);
  return compareWithLast(prior);
}

Frame& MatchFilter::nextFrame() {
  if (have_current_) {
    std::swap(reference_, current_);
    have_reference_ = true;
    have_current_ = false;
  }
  return current_;
}

const MatchResult& MatchFilter::compareWithLast(const RotationPrior* prior) {
  if (!reference_.features.descriptors.comparableWith(current_.features.descriptors)) reset();
  have_current_ = true;
  if (!have_reference_) {
    result_.clear(Status::kFirstFrame);
    result_.keypoints_current = current_.features.size();
    result_.times.detect = current_.detect_seconds;
    return result_;
  }
  filter(reference_, current_, result_, prior, &past_);
  TrackTable& tracks = stages_->tracks;
  tracks.link(result_);
  tracks.advance();
  result_.track_id = tracks.ids();
  result_.track_length = tracks.lengths();
  return result_;
}

void MatchFilter::extract(const cv::Mat& image, Frame& frame, const cv::Mat& mask, std::optional<double> stamp) {
  Stages& stages = *stages_;
  if (image.type() != CV_8UC1) throw std::invalid_argument("MatchFilter: the image must be CV_8UC1 (grey, 8 bit)");
  StopWatch watch(stages.clock);
  frame.features_asked = stages.budget ? stages.budget->features(image.size()) : options_.extractor.features;
  stages.extractor->extract(image, frame.features, mask, frame.features_asked);
  frame.detect_seconds = watch.lap();
  frame.stamp = stamp;
}

void MatchFilter::filter(const Frame& reference, const Frame& current, MatchResult& result, const RotationPrior* prior,
                         Past* past) {
  requireCameraSize(reference.features.image_size);
  requireCameraSize(current.features.image_size);
  result.clear(Status::kOk);
  result.keypoints_reference = reference.features.size();
  result.keypoints_current = current.features.size();
  result.times.detect = current.detect_seconds;
  if (prior != nullptr) result.pairs.rotation_prior = *prior;
  if (past != nullptr) {
    past->startPair(reference.features, current.features);
    result.pairs.previous_motion = past->motion;
    result.pairs.global_shutter = past->shutter.shutter().kind == Shutter::kGlobal;
  }
  if (reference.stamp && current.stamp) result.pairs.seconds = *current.stamp - *reference.stamp;
  result.status = compare(reference, current, result, past);
  if (stages_->budget) recordCost(reference, current, result, *stages_->budget);
}

Status MatchFilter::compare(const Frame& reference_frame, const Frame& current_frame, MatchResult& result, Past* past) {
  Stages& stages = *stages_;
  const Camera& camera = stages.camera;
  const Features &reference = reference_frame.features, &current = current_frame.features;
  if (std::min(reference.size(), current.size()) < kMinimumMatches) return Status::kTooFewKeypoints;

  StopWatch watch(stages.clock);
  if (!reference.descriptors.is256Bit() || !current.descriptors.is256Bit()) {
    matchMutually(reference.descriptors, current.descriptors, result.raw);
  } else if (stages.guided_search) {
    const std::optional<RotationPrior>& prior = result.pairs.rotation_prior;
    const bool predicts = prior && camera.calibrated() && camera.imageSize() == reference.image_size;
    if (predicts) predictRotation(*prior, camera, stages.rotation_prediction);
    stages.guided_search->match(reference, current, result.raw, predicts ? &stages.rotation_prediction : nullptr);
  } else {
    stages.matcher.match(reference.descriptors, current.descriptors, result.raw);
  }
  result.times.match = watch.lap();
  if (result.raw.size() < kMinimumMatches) return Status::kTooFewMatches;

  const MotionStatistics& statistics = stages.method->filter(reference, current, result.raw);
  stages.selector.select(reference, current, statistics, camera, result);
  result.times.gms = watch.lap();
  if (result.size() < kMinimumMatches) return Status::kGmsRejected;

  return estimateSurvivors(reference_frame, current_frame, result, past);
}

void MatchFilterHooks::estimate(MatchFilter& filter, const Frame& reference, const Frame& current,
                                MatchResult& result) {
  if (result.size() < kMinimumMatches) return;
  result.times.ransac = 0;
  result.status = filter.estimateSurvivors(reference, current, result, nullptr);
}

Status MatchFilter::estimateSurvivors(const Frame& reference, const Frame& current, MatchResult& result, Past* past) {
  Stages& stages = *stages_;
  if (stages.budget) {
    stages.budget->limitSearch(current.seconds_before + result.times.total(), current.features.size());
  }
  StopWatch watch(stages.clock);
  stages.method->estimate(result.pairs, stages.camera, result.robust);
  stages.method->postFilter(reference.features, current.features, result);
  // Fewer inliers are no model.
  if (result.robust.inlier_count < kMinimumMatches) result.robust.reject();
  if (options_.robust.judge) {
    stages.fixed_to_camera.resolve(*stages.method, stages.camera, result, past);
    doubtRepetition(reference.features, current.features, result);
  }
  if (past != nullptr) {
    stages.continuity.check(*stages.method, stages.camera, options_.robust, result, *past);
    result.shutter = past->shutter.shutter();
  }
  const RobustResult& robust = result.robust;
  const bool may_rest =
      !robust.judgement.translation_observable && robust.judgement.doubt != DirectionDoubt::kFixedToCamera;
  result.stationary = may_rest && standsStill(reference.features, current.features, result, past);
  result.inlier = robust.inlier;
  if (stages.method->filterDecides()) result.inlier.assign(result.matches.size(), 1);
  result.inliers = static_cast<int>(std::count(result.inlier.begin(), result.inlier.end(), 1));
  result.times.ransac = watch.lap();
  return statusOf(robust, stages.camera);
}

void MatchFilter::doubtRepetition(const Features& reference, const Features& current, MatchResult& result) {
  RobustResult& robust = result.robust;
  const DescriptorSet& descriptors = reference.descriptors;  // none of points that a caller gives
  if (!robust.judgement.translation_observable || descriptors.size() == 0 || !descriptors.is256Bit()) return;
  const std::optional<double> period = stages_->repetition.period(reference, current, result.matches, robust.inlier);
  if (!period) return;
  robust.judgement.refuse(DirectionDoubt::kRepetition);
  // A rotation by a period explains the pattern as well.
  const double angle = *period / stages_->camera.K()(0, 0);
  robust.judgement.pose.covariance.diagonal().tail<3>().array() += angle * angle;
}

void MatchFilter::setClock(const std::function<double()>& seconds) {
  Stages& stages = *stages_;
  stages.clock = seconds;
  if (options_.max_milliseconds <= 0) return;
  stages.budget = std::make_shared<TimeBudget>(1e-3 * options_.max_milliseconds, options_.extractor.features, seconds);
  stages.method->setTimeLimit(&stages.budget->limit());
}

void MatchFilter::continueBudget(const MatchFilter& before) {
  MatchFilterOptions comparable = before.options_;
  comparable.robust = options_.robust;
  comparable.robust.model = before.options_.robust.model;
  comparable.robust.refine = before.options_.robust.refine;
  const bool same = parametersOf(comparable) == parametersOf(options_) &&
                    comparable.extractor.threads == options_.extractor.threads &&
                    comparable.matcher_threads == options_.matcher_threads;
  if (!same || !before.stages_->budget) return;
  stages_->budget = before.stages_->budget;
  stages_->method->setTimeLimit(&stages_->budget->limit());
}

void MatchFilterHooks::setClock(MatchFilter& filter, const std::function<double()>& seconds) {
  filter.setClock(seconds);
}

void MatchFilterHooks::setSeed(MatchFilter& filter, uint64_t seed) {
  filter.options_.robust.seed = seed;
  filter.stages_->method->setSeed(seed);
}

}  // namespace gms_ransac
