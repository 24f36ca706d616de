// The line, and what it says of the raw matches.
#include "gms_ransac/match_filter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "matching/turn_prediction.h"
#include "survivors.h"
#include "time_budget.h"
#include "validation.h"

namespace gms_ransac {

namespace {

/// Seconds since construction or the last lap.
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

// The columns beside the raw matches, as far as each stage knows them.

void markRaw(MatchResult& result) {
  result.stage.assign(result.matches.size(), MatchStage::kRaw);
  result.confidence.assign(result.matches.size(), 0.f);
  result.probability.assign(result.matches.size(), 0.f);
}

void markSurvivors(MatchResult& result) {
  const std::vector<int32_t>& score = result.survivors.pairs.score;
  const int32_t largest = score.empty() ? 0 : *std::max_element(score.begin(), score.end());
  for (size_t k = 0; k < score.size(); ++k) {
    const auto i = static_cast<size_t>(result.survivors.match[k]);
    result.stage[i] = MatchStage::kGms;
    result.confidence[i] = largest > 0 ? static_cast<float>(score[k]) / static_cast<float>(largest) : 1.f;
  }
  result.matches_gms = result.survivors.size();
}

/// `all`: the filter alone decides, whatever the model says.
void markInliers(bool all, MatchResult& result) {
  const RobustResult& robust = result.robust;
  for (size_t k = 0; k < result.survivors.match.size(); ++k) {
    const auto i = static_cast<size_t>(result.survivors.match[k]);
    result.stage[i] = all || robust.inlier[k] ? MatchStage::kInlier : MatchStage::kGms;
    result.probability[i] = robust.probability.empty() ? 0 : robust.probability[k];
  }
  result.inliers = all ? result.matches_gms : robust.inlier_count;
}

}  // namespace

std::string toString(Status status) {
  switch (status) {
    case Status::kOk:
      return "OK";
    case Status::kFirstFrame:
      return "FIRST_FRAME";
    case Status::kTooFewKeypoints:
      return "TOO_FEW_KEYPOINTS";
    case Status::kTooFewMatches:
      return "TOO_FEW_MATCHES";
    case Status::kGmsRejected:
      return "GMS_REJECTED";
    case Status::kRansacFailed:
      return "RANSAC_FAILED";
    case Status::kLowParallax:
      return "LOW_PARALLAX";
    case Status::kUncalibrated:
      return "UNCALIBRATED";
  }
  return "UNKNOWN";
}

Status statusOf(const RobustResult& result, const Camera& camera) {
  if (!result.model_found || result.inlier_count < kMinimumMatches) return Status::kRansacFailed;
  if (!camera.calibrated()) return Status::kUncalibrated;
  if (!result.pose_found) return Status::kRansacFailed;
  return result.translation_observable ? Status::kOk : Status::kLowParallax;
}

void PointPairs::resize(int n) {
  const auto size = static_cast<size_t>(n);
  for (auto* column : {&x_reference, &y_reference, &x_current, &y_current, &relative_score}) column->resize(size);
  for (auto* column : {&octave_reference, &octave_current}) column->resize(size);
  score.resize(size);
  for (auto* column : {&distance, &second_distance}) column->resize(size);
}

bool PointPairs::hasCoordinates(size_t i) const {
  constexpr float kFarthest = 1e6f;  // a fisheye lens of 10000 px reaches as far, 0.6 degrees short of a right angle
  const auto isCoordinate = [](float value) { return std::abs(value) < kFarthest; };  // nor NaN
  return isCoordinate(x_reference[i]) && isCoordinate(y_reference[i]) && isCoordinate(x_current[i]) &&
         isCoordinate(y_current[i]);
}

void MatchResult::clear(Status new_status) {
  status = new_status;
  keypoints_reference = keypoints_current = matches_gms = inliers = 0;
  matches.clear();
  stage.clear();
  confidence.clear();
  probability.clear();
  survivors.match.clear();
  survivors.pairs.resize(0);
  survivors.pairs.rotation_prior.reset();
  survivors.pairs.seconds.reset();
  robust.clear();
  times = StageTimes();
}

void MatchFilterOptions::validate() const {
  findMethod(method);
  extractor.validate();
  motion_statistics.validate();
  HammingMatcherOptions matcher;
  matcher.threads = matcher_threads;
  matcher.validate();
  requireInRanges(*this);
  robust.validate();
}

MatchFilterOptions MatchFilterOptions::paper() {
  MatchFilterOptions options;
  options.method = "cp_ransac";
  options.extractor.extractor = "opencv";
  options.one_to_one = false;
  options.robust.sort_key = SortKey::kScore;
  options.robust.first_group_fraction = 0.5;
  options.robust.refine = options.robust.judge = false;
  return options;
}

MatchFilter::MatchFilter(const MatchFilterOptions& options)
    : options_(options),
      method_(makeMethod(options)),
      extractor_(makeFeatureExtractor(options.extractor)),
      matcher_(matcherOptions(options, *method_)),
      selector_(std::make_unique<SurvivorSelector>(options.one_to_one, options.robust.rolling_shutter_readout > 0)) {
  const HammingMatcherOptions matcher = matcherOptions(options, *method_);
  if (options.search == SearchMode::kGuided && !matcher.mutual) {
    guided_search_.emplace(matcher, options.motion_statistics);
  }
  setClock(steadySeconds);
}

MatchFilter::~MatchFilter() = default;
MatchFilter::MatchFilter(MatchFilter&&) noexcept = default;
MatchFilter& MatchFilter::operator=(MatchFilter&&) noexcept = default;

void MatchFilter::setCamera(const Camera& camera) {
  if (camera_ != camera) camera_ = camera;
}

void MatchFilter::reset() {
  have_reference_ = false;
  method_->reset();
}

const MatchResult& MatchFilter::process(const cv::Mat& image, const cv::Mat& mask, std::optional<double> stamp) {
  extract(image, current_, mask, stamp);
  if (have_reference_) {
    filter(reference_, current_, result_);
  } else {
    result_.clear(Status::kFirstFrame);
    result_.keypoints_current = current_.features.size();
    result_.times.detect = current_.detect_seconds;
  }
  std::swap(reference_, current_);
  have_reference_ = true;
  return result_;
}

void MatchFilter::extract(const cv::Mat& image, Frame& frame, const cv::Mat& mask, std::optional<double> stamp) {
  if (image.type() != CV_8UC1) throw std::invalid_argument("MatchFilter: the image must be CV_8UC1 (grey, 8 bit)");
  StopWatch watch(clock_);
  frame.features_asked = budget_ ? budget_->features(image.size()) : options_.extractor.features;
  extractor_->extract(image, frame.features, mask, frame.features_asked);
  frame.detect_seconds = watch.lap();
  frame.stamp = stamp;
}

void MatchFilter::filter(const Frame& reference, const Frame& current, MatchResult& result,
                         const RotationPrior* prior) {
  result.clear(Status::kOk);
  result.keypoints_reference = reference.features.size();
  result.keypoints_current = current.features.size();
  result.times.detect = current.detect_seconds;
  if (prior != nullptr) result.survivors.pairs.rotation_prior = *prior;
  if (reference.stamp && current.stamp) result.survivors.pairs.seconds = *current.stamp - *reference.stamp;
  result.status = compare(reference, current, result);
  if (budget_) learn(reference, current, result);
}

void MatchFilter::learn(const Frame& reference, const Frame& current, const MatchResult& result) {
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
  budget_->learn(cost);
}

Status MatchFilter::compare(const Frame& reference_frame, const Frame& current_frame, MatchResult& result) {
  const Features &reference = reference_frame.features, &current = current_frame.features;
  if (std::min(reference.size(), current.size()) < kMinimumMatches) return Status::kTooFewKeypoints;

  StopWatch watch(clock_);
  if (guided_search_) {
    const std::optional<RotationPrior>& prior = result.survivors.pairs.rotation_prior;
    const bool predicts = prior && camera_.calibrated() && camera_.imageSize() == reference.image_size;
    if (predicts) predictTurn(*prior, camera_, turn_);
    guided_search_->match(reference, current, result.matches, predicts ? &turn_ : nullptr);
  } else {
    matcher_.match(reference.descriptors, current.descriptors, result.matches);
  }
  markRaw(result);
  result.times.match = watch.lap();
  if (result.matches.size() < kMinimumMatches) return Status::kTooFewMatches;

  const MotionStatistics& statistics = method_->filter(reference, current, result.matches);
  selector_->select(reference, current, result.matches, statistics, camera_, result.survivors);
  markSurvivors(result);
  result.times.gms = watch.lap();
  if (result.survivors.size() < kMinimumMatches) return Status::kGmsRejected;

  if (budget_) budget_->limitSearch(current_frame.seconds_before + result.times.total(), current.size());
  return estimate(reference, current, result);
}

void MatchFilter::estimate(const Frame& reference, const Frame& current, MatchResult& result) {
  if (result.survivors.size() < kMinimumMatches) return;
  result.status = estimate(reference.features, current.features, result);
}

Status MatchFilter::estimate(const Features& reference, const Features& current, MatchResult& result) {
  StopWatch watch(clock_);
  const Survivors& survivors = result.survivors;
  method_->estimate(survivors.pairs, camera_, result.robust);
  method_->postFilter(reference, current, result.matches, survivors.match, result.robust);
  // What fewer agree on is no model, whichever stage took the others away.
  if (result.robust.inlier_count < kMinimumMatches) result.robust.reject();
  markInliers(method_->filterDecides(), result);
  result.times.ransac = watch.lap();
  return statusOf(result.robust, camera_);
}

void MatchFilter::setClock(const Clock& clock) {
  clock_ = clock;
  if (options_.max_milliseconds <= 0) return;
  budget_ = std::make_unique<TimeBudget>(1e-3 * options_.max_milliseconds, options_.extractor.features, clock);
  method_->setTimeLimit(&budget_->limit());
}

void MatchFilter::setSeed(uint64_t seed) {
  options_.robust.seed = seed;
  method_->setSeed(seed);
}

}  // namespace gms_ransac
