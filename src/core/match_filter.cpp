// The pipeline: `compare` tells it, and the stages below it are in its order.
#include "gms_ransac/match_filter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <opencv2/core.hpp>

#include "alignment.h"
#include "gms/guided_search.h"
#include "gms/motion_prediction.h"
#include "judgement/probability.h"
#include "match_filter_hooks.h"
#include "matching/any_matcher.h"
#include "methods/method.h"
#include "parameters/parameter.h"
#include "past/continuity.h"
#include "past/fixed_to_camera.h"
#include "past/mask_learner.h"
#include "past/standstill.h"
#include "past/votes.h"
#include "support/time_budget.h"
#include "survivors.h"
#include "tracks/track_table.h"

namespace gms_ransac {

namespace {

/// Two images, and what came before them.
struct FramePair {
  const Frame &reference, &current;
  Past* past;  ///< of the stream; null: the pair stands alone
};

/// Adds its lifetime to the seconds of a stage.
class StageTimer {
 public:
  StageTimer(const Clock& clock, double& seconds) : clock_(clock), seconds_(seconds), begin_(clock()) {}
  ~StageTimer() { seconds_ += clock_() - begin_; }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  const Clock& clock_;
  double& seconds_;
  double begin_;
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

/// Fills in all that is known before the first stage.
void beginPair(const FramePair& pair, const RotationPrior* prior, MatchResult& result) {
  const auto& [reference, current, past] = pair;
  result.clear(Status::kOk);
  result.keypoints_reference = reference.features.size();
  result.keypoints_current = current.features.size();
  result.times.detect = current.detect_seconds;
  if (prior != nullptr) result.pairs.rotation_prior = *prior;
  if (reference.stamp && current.stamp) result.pairs.seconds = *current.stamp - *reference.stamp;
  if (past == nullptr) return;
  past->startPair(reference.features, current.features);
  result.mask = past->mask;
  result.pairs.previous_motion = past->motion;
  result.pairs.shutter = past->shutter.shutter();
  result.pairs.velocity_before = past->shutter.velocityBefore();
}

void flagInliers(bool all, MatchResult& result) {
  result.inlier = result.robust.inlier;
  if (all) result.inlier.assign(result.matches.size(), 1);
  result.inliers = static_cast<int>(std::count(result.inlier.begin(), result.inlier.end(), 1));
}

/// Copies of a frame share their image, which therefore is not written to.
void keepImage(const cv::Mat& image, Frame& frame) {
  if (frame.image.u != nullptr && frame.image.u->refcount > 1) frame.image.release();
  image.copyTo(frame.image);
}

void recordCost(const FramePair& pair, const MatchResult& result, TimeBudget& budget) {
  const Frame& current = pair.current;
  PairCost cost;
  cost.pixels = current.features.image_size.area();
  cost.asked = current.features_asked;
  cost.reference = pair.reference.features.size();
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

/// Each stage fills its part of the result, and keeps nothing but storage from pair to pair.
struct MatchFilter::Stages {
  explicit Stages(const MatchFilterOptions& given);

  /// The whole algorithm, on the features of two images. The first stage that leaves too little ends it.
  Status compare(const FramePair& pair, MatchResult& result);
  void match(const FramePair& pair, MatchResult& result);
  /// Keeps what the motion statistics accept, or what the method has in their place.
  void filter(const FramePair& pair, MatchResult& result);
  /// Moves points to where both images look alike.
  void align(const FramePair& pair, MatchResult& result);
  void estimate(const FramePair& pair, MatchResult& result);
  /// Holds the estimate against what else is seen and what was before: another motion may take its place, or evidence
  /// is added.
  void judge(const FramePair& pair, MatchResult& result);

  /// Where a rotation from another sensor moves the keypoints; null: not known.
  const MotionPrediction* predict(const std::optional<RotationPrior>& prior, const cv::Size& image);
  void setClock(const Clock& seconds);

  MatchFilterOptions options;
  Clock clock;
  Camera camera;
  std::unique_ptr<Method> method;
  std::unique_ptr<FeatureExtractor> extractor;
  HammingMatcher matcher;
  std::optional<GuidedSearch> guided_search;  ///< replaces the matcher
  MotionPrediction rotation_prediction;
  SurvivorSelector selector;
  Alignment alignment;
  FixedToCamera fixed_to_camera;
  Continuity continuity;
  Votes votes;
  TrackTable tracks;                   ///< of the sequence that is given to `process`
  std::shared_ptr<TimeBudget> budget;  ///< null: no limit
};

const MatchResult& MatchFilter::process(const cv::Mat& image, const cv::Mat& mask, std::optional<double> stamp,
                                        const RotationPrior* prior) {
  requireCameraSize(image.size());
  extract(image, nextFrame(), past_.mask.forExtraction(mask, image.size()), stamp);
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
  frame.detect_seconds = 0;
  const StageTimer timer(stages.clock, frame.detect_seconds);
  frame.features_asked = stages.budget ? stages.budget->features(image.size()) : options().extractor.features;
  stages.extractor->extract(image, frame.features, mask, frame.features_asked);
  keepImage(image, frame);
  frame.stamp = stamp;
}

void MatchFilter::filter(const Frame& reference, const Frame& current, MatchResult& result, const RotationPrior* prior,
                         Past* past) {
  requireCameraSize(reference.features.image_size);
  requireCameraSize(current.features.image_size);
  const FramePair pair = {reference, current, past};
  beginPair(pair, prior, result);
  result.status = stages_->compare(pair, result);
  if (stages_->budget) recordCost(pair, result, *stages_->budget);
}

Status MatchFilter::Stages::compare(const FramePair& pair, MatchResult& result) {
  if (std::min(result.keypoints_reference, result.keypoints_current) < kMinimumMatches) return Status::kTooFewKeypoints;
  match(pair, result);
  if (result.raw.size() < kMinimumMatches) return Status::kTooFewMatches;
  filter(pair, result);
  if (result.size() < kMinimumMatches) return Status::kGmsRejected;
  align(pair, result);
  estimate(pair, result);
  judge(pair, result);
  if (pair.past != nullptr) continuePast(result, *pair.past);
  return statusOf(result.robust, camera);
}

void MatchFilter::Stages::match(const FramePair& pair, MatchResult& result) {
  const StageTimer timer(clock, result.times.match);
  const Features &reference = pair.reference.features, &current = pair.current.features;
  if (!reference.descriptors.is256Bit() || !current.descriptors.is256Bit()) {
    matchMutually(reference.descriptors, current.descriptors, result.raw);
  } else if (guided_search) {
    guided_search->match(reference, current, result.raw, predict(result.pairs.rotation_prior, reference.image_size));
  } else {
    matcher.match(reference.descriptors, current.descriptors, result.raw);
  }
  leaveOutMasked(reference, current, result);
}

const MotionPrediction* MatchFilter::Stages::predict(const std::optional<RotationPrior>& prior, const cv::Size& image) {
  if (!prior || !camera.calibrated() || camera.imageSize() != image) return nullptr;
  predictRotation(*prior, camera, rotation_prediction);
  return &rotation_prediction;
}

void MatchFilter::Stages::filter(const FramePair& pair, MatchResult& result) {
  const StageTimer timer(clock, result.times.gms);
  const Features &reference = pair.reference.features, &current = pair.current.features;
  selector.select(reference, current, method->filter(reference, current, result.raw), camera, result);
}

void MatchFilter::Stages::align(const FramePair& pair, MatchResult& result) {
  const StageTimer timer(clock, result.times.gms);
  if (options.align_points) alignment.align(pair.reference, pair.current, camera, result);
}

void MatchFilter::Stages::estimate(const FramePair& pair, MatchResult& result) {
  const Frame& current = pair.current;
  if (budget) budget->limitSearch(current.seconds_before + result.times.total(), current.features.size());
  const StageTimer timer(clock, result.times.ransac);
  method->estimate(result.pairs, camera, result.robust);
  method->postFilter(pair.reference.features, current.features, result);
  // Fewer inliers are no model.
  if (result.robust.inlier_count < kMinimumMatches) result.robust.reject();
}

void MatchFilter::Stages::judge(const FramePair& pair, MatchResult& result) {
  const StageTimer timer(clock, result.times.ransac);
  Judgement& judgement = result.robust.judgement;
  if (options.robust.judge) {
    fixed_to_camera.resolve(*method, camera, result, pair.past);
    if (pair.past != nullptr) continuity.check(*method, camera, result, *pair.past);
    votes.collect(pair.reference.features, pair.current.features, camera, result);
    if (judgement.pose_found) decide(options.robust, judgement);
    if (pair.past != nullptr && camera.calibrated()) {
      learnMask(pair.reference.features, pair.current.features, camera, result, fixed_to_camera.view(result),
                pair.past->mask);
    }
  }
  const bool may_rest = !judgement.translation_observable && std::isnan(judgement.evidence[Evidence::kFixedToCamera]);
  result.stationary = may_rest && standsStill(pair.reference.features, pair.current.features, result, pair.past);
  flagInliers(method->filterDecides(), result);
}

MatchFilterOptions MatchFilterOptions::paper() {
  MatchFilterOptions options;
  options.method = "cp_ransac";
  options.extractor.extractor = "opencv";
  options.extractor.pyramid_levels = 8;
  options.extractor.pyramid_scale = 1.2;
  options.search = SearchMode::kFull;
  options.one_to_one = options.align_points = false;
  options.robust.sort_key = SortKey::kScore;
  options.robust.first_group_fraction = 0.5;
  options.robust.refine = options.robust.judge = false;
  return options;
}

MatchFilter::Stages::Stages(const MatchFilterOptions& given)
    : options(given),
      method(makeMethod(options)),
      extractor(makeFeatureExtractor(options.extractor)),
      matcher(matcherOptions(options, *method)),
      selector(options.one_to_one, options.robust.rolling_shutter_readout != 0),
      alignment(options.robust.simd) {
  // A filter that decides alone would take every match that agrees with the predicted motion for an inlier.
  if (options.search == SearchMode::kGuided && !method->wantsMutualMatches() && !method->filterDecides()) {
    guided_search.emplace(matcherOptions(options, *method), options.motion_statistics);
  }
  setClock(steadySeconds);
}

void MatchFilter::Stages::setClock(const Clock& seconds) {
  clock = seconds;
  if (options.max_milliseconds <= 0) return;
  budget = std::make_shared<TimeBudget>(1e-3 * options.max_milliseconds, options.extractor.features, seconds);
  method->setTimeLimit(&budget->limit());
}

MatchFilter::MatchFilter(const MatchFilterOptions& options) : stages_(std::make_unique<Stages>(options)) {}

MatchFilter::~MatchFilter() = default;
MatchFilter::MatchFilter(MatchFilter&&) noexcept = default;
MatchFilter& MatchFilter::operator=(MatchFilter&&) noexcept = default;

const MatchFilterOptions& MatchFilter::options() const { return stages_->options; }

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

void MatchFilter::continueBudget(const MatchFilter& before) {
  MatchFilterOptions comparable = before.options();
  comparable.robust = options().robust;
  comparable.robust.model = before.options().robust.model;
  comparable.robust.refine = before.options().robust.refine;
  const bool same = parametersOf(comparable) == parametersOf(options()) &&
                    comparable.extractor.threads == options().extractor.threads &&
                    comparable.matcher_threads == options().matcher_threads;
  if (!same || !before.stages_->budget) return;
  stages_->budget = before.stages_->budget;
  stages_->method->setTimeLimit(&stages_->budget->limit());
}

void MatchFilterHooks::setClock(MatchFilter& filter, const std::function<double()>& seconds) {
  filter.stages_->setClock(seconds);
}

void MatchFilterHooks::setSeed(MatchFilter& filter, uint64_t seed) {
  filter.stages_->options.robust.seed = seed;
  filter.stages_->method->setSeed(seed);
}

void MatchFilterHooks::estimate(MatchFilter& filter, const Frame& reference, const Frame& current,
                                MatchResult& result) {
  if (result.size() < kMinimumMatches) return;
  result.times.ransac = 0;
  const FramePair pair = {reference, current, nullptr};
  filter.stages_->estimate(pair, result);
  filter.stages_->judge(pair, result);
  result.status = statusOf(result.robust, filter.camera());
}

}  // namespace gms_ransac
