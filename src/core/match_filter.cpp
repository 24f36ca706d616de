#include "gms_ransac/match_filter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "validation.h"

namespace gms_ransac {

namespace {

/// Seconds since construction or the last lap.
class StopWatch {
 public:
  double lap() {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

HammingMatcherOptions matcherOptions(const MatchFilterOptions& options, const Method& method) {
  HammingMatcherOptions matcher;
  matcher.mutual = method.wantsMutualMatches();
  matcher.threads = options.matcher_threads;
  return matcher;
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
      matcher_(matcherOptions(options, *method_)) {}

void MatchFilter::setCamera(const Camera& camera) {
  if (camera_ != camera) camera_ = camera;
}

void MatchFilter::reset() {
  have_reference_ = false;
  method_->reset();
}

const MatchResult& MatchFilter::process(const cv::Mat& image, const cv::Mat& mask) {
  extract(image, current_, mask);
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

void MatchFilter::extract(const cv::Mat& image, Frame& frame, const cv::Mat& mask) {
  if (image.type() != CV_8UC1) throw std::invalid_argument("MatchFilter: the image must be CV_8UC1 (grey, 8 bit)");
  StopWatch watch;
  extractor_->extract(image, frame.features, mask);
  frame.detect_seconds = watch.lap();
}

void MatchFilter::filter(const Frame& reference, const Frame& current, MatchResult& result,
                         const RotationPrior* prior) {
  result.clear(Status::kOk);
  result.keypoints_reference = reference.features.size();
  result.keypoints_current = current.features.size();
  result.times.detect = current.detect_seconds;
  if (std::min(result.keypoints_reference, result.keypoints_current) < kMinimumMatches) {
    result.status = Status::kTooFewKeypoints;
    return;
  }

  StopWatch watch;
  matcher_.match(reference.features.descriptors, current.features.descriptors, result.matches);
  result.stage.assign(result.matches.size(), MatchStage::kRaw);
  result.confidence.assign(result.matches.size(), 0.f);
  result.probability.assign(result.matches.size(), 0.f);
  result.times.match = watch.lap();
  if (result.matches.size() < kMinimumMatches) {
    result.status = Status::kTooFewMatches;
    return;
  }

  method_->filter(reference.features, current.features, result.matches, statistics_);
  selectSurvivors(reference.features, current.features, result);
  describeSurvivors(reference.features, current.features, result);
  pairs_.rotation_prior.reset();
  if (prior != nullptr) pairs_.rotation_prior = *prior;
  result.times.gms = watch.lap();
  if (result.matches_gms < kMinimumMatches) {
    result.status = Status::kGmsRejected;
    return;
  }

  estimate(reference, current, result);
}

void MatchFilter::setSeed(uint64_t seed) {
  options_.robust.seed = seed;
  method_->setSeed(seed);
}

void MatchFilter::estimate(const Frame& reference, const Frame& current, MatchResult& result) {
  if (result.matches_gms < kMinimumMatches) return;
  result.status = Status::kOk;
  result.inliers = 0;
  for (int match : survivors_) result.stage[match] = MatchStage::kGms;
  StopWatch watch;
  method_->estimate(pairs_, camera_, result.robust);
  method_->postFilter(reference.features, current.features, result.matches, survivors_, result.robust);
  // What fewer agree on is no model, whichever stage took the others away.
  if (result.robust.inlier_count < kMinimumMatches) result.robust.reject();
  markInliers(result);
  copyProbabilities(result);
  result.times.ransac = watch.lap();
}

void MatchFilter::selectSurvivors(const Features& reference, const Features& current, MatchResult& result) {
  survivors_.clear();
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (!statistics_.accepted[i]) continue;
    if (hasRays(reference, current, result.matches[i])) survivors_.push_back(static_cast<int>(i));
  }
  if (options_.one_to_one) keepOneForEachPoint(result);
  result.matches_gms = static_cast<int>(survivors_.size());
}

void MatchFilter::keepOneForEachPoint(const MatchResult& result) {
  // The log-odds of being right include the descriptors; a score alone says which cell is the fullest.
  const std::vector<float>& log_odds = statistics_.log_odds;
  const auto better = [&](int a, int b) {
    if (!log_odds.empty() && log_odds[a] != log_odds[b]) return log_odds[a] > log_odds[b];
    return result.matches[a].distance < result.matches[b].distance;
  };
  constexpr int kNone = -1;
  best_match_.assign(static_cast<size_t>(result.keypoints_current), kNone);
  for (const int i : survivors_) {
    int& best = best_match_[result.matches[i].current];
    if (best == kNone || better(i, best)) best = i;
  }
  const auto beaten = [&](int i) { return best_match_[result.matches[i].current] != i; };
  survivors_.erase(std::remove_if(survivors_.begin(), survivors_.end(), beaten), survivors_.end());
}

void MatchFilter::describeSurvivors(const Features& reference, const Features& current, MatchResult& result) {
  int largest_score = 0;
  for (const int i : survivors_) largest_score = std::max(largest_score, statistics_.score[i]);

  const int n = static_cast<int>(survivors_.size());
  pairs_.resize(n);
  pairs_.image_reference = reference.image_size;
  pairs_.image_current = current.image_size;
  pairs_.scale_factor = current.scale_factor;
  for (int k = 0; k < n; ++k) {
    const int i = survivors_[k];
    const Match& match = result.matches[i];
    const cv::KeyPoint& a = reference.keypoints[match.reference];
    const cv::KeyPoint& b = current.keypoints[match.current];
    const cv::Point2f p = camera_.undistort(a.pt), q = camera_.undistort(b.pt);
    pairs_.x_reference[k] = p.x;
    pairs_.y_reference[k] = p.y;
    pairs_.x_current[k] = q.x;
    pairs_.y_current[k] = q.y;
    pairs_.octave_reference[k] = static_cast<uint8_t>(a.octave);
    pairs_.octave_current[k] = static_cast<uint8_t>(b.octave);
    pairs_.score[k] = statistics_.score[i];
    pairs_.relative_score[k] = statistics_.relative_score[i];
    pairs_.distance[k] = match.distance;
    pairs_.second_distance[k] = match.second_distance;
    result.stage[i] = MatchStage::kGms;
    result.confidence[i] =
        largest_score > 0 ? static_cast<float>(statistics_.score[i]) / static_cast<float>(largest_score) : 1.f;
  }
}

bool MatchFilter::hasRays(const Features& reference, const Features& current, const Match& match) const {
  if (camera_.pixelsWithoutInverse() == 0) return true;
  const cv::Point2f p = camera_.undistort(reference.keypoints[match.reference].pt);
  const cv::Point2f q = camera_.undistort(current.keypoints[match.current].pt);
  return !std::isnan(p.x) && !std::isnan(q.x);
}

void MatchFilter::markInliers(MatchResult& result) {
  const RobustResult& robust = result.robust;
  if (method_->filterDecides()) {
    for (const int match : survivors_) result.stage[match] = MatchStage::kInlier;
    result.inliers = result.matches_gms;
  }
  if (!robust.model_found) {
    result.status = Status::kRansacFailed;
    return;
  }
  if (!method_->filterDecides()) {
    for (size_t k = 0; k < survivors_.size(); ++k) {
      if (robust.inlier[k]) result.stage[survivors_[k]] = MatchStage::kInlier;
    }
    result.inliers = robust.inlier_count;
  }
  if (!camera_.calibrated()) {
    result.status = Status::kUncalibrated;
  } else if (!robust.pose_found) {
    result.status = Status::kRansacFailed;
  } else if (!robust.translation_observable) {
    result.status = Status::kLowParallax;
  }
}

void MatchFilter::copyProbabilities(MatchResult& result) const {
  const std::vector<float>& weighed = result.robust.probability;
  for (size_t k = 0; k < survivors_.size(); ++k) {
    result.probability[static_cast<size_t>(survivors_[k])] = weighed.empty() ? 0 : weighed[k];
  }
}

}  // namespace gms_ransac
