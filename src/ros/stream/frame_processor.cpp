#include "stream/frame_processor.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "gms_ransac/camera.h"
#include "guard.h"
#include "scale/translation_scale.h"
#include "stream/status_text.h"
#include "text.h"

namespace gms_ransac {

namespace {

// Share of the reference's keypoints that must be inliers for it to be kept. Successive images of a handheld camera
// have 0.4 to 0.7 (TUM freiburg1, 2000 keypoints), so the view has shifted by about half when it falls below.
constexpr double kWellSeen = 0.2;
// The next image is expected within this many times the interval between the last two.
constexpr double kLateImage = 2;
// After a loss image after image is compared with every kept one, which may show another place: that many tries leave
// more to chance than one pair of neighbours does. Among 5000 pairs of images of different places (four real sets,
// three rendered rooms) 83 pass for the same place, with 17 inliers at most.
constexpr int kSureInliers = 30;

/// Without keypoints nothing can be compared with the image.
bool isUseless(const ProcessedFrame& processed) {
  return processed.status == MatchStats::TOO_FEW_KEYPOINTS &&
         processed.current->frame.features.size() < kMinimumMatches;
}

/// Treats the pair as one without a model.
void rejectModel(MatchResult& result) {
  std::replace(result.stage.begin(), result.stage.end(), MatchStage::kInlier, MatchStage::kGms);
  std::fill(result.probability.begin(), result.probability.end(), 0.f);
  result.inliers = 0;
  result.robust.reject();
  result.status = Status::kRansacFailed;
}

/// Returns freed pages to the system: glibc keeps them per arena otherwise.
void giveBackMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace

FrameProcessor::FrameProcessor(const Parameters& parameters, const std::string& image_topic,
                               const std::string& info_topic, std::shared_ptr<MotionPriors> priors,
                               const std::string& right_topic, const std::string& right_info_topic)
    : image_topic_(image_topic),
      priors_(std::move(priors)),
      preparation_(parameters, image_topic, info_topic, right_topic, right_info_topic),
      pair_pose_(parameters, priors_) {}

void FrameProcessor::setOptions(const ProcessorOptions& options) {
  const auto end = [](MatchFilter* replaced) {
    delete replaced;
    giveBackMemory();
  };
  std::shared_ptr<MatchFilter> filter(new MatchFilter(options.core), end);
  if (priors_) priors_->setReadout(options.core.robust.rolling_shutter_readout);
  std::unique_ptr<PreparedFrame> spare;
  std::lock_guard<std::mutex> lock(mutex_);
  filter_.swap(filter);  // the replaced one ends without the lock, after its frame
  spare_.swap(spare);
  options_ = options;
}

void FrameProcessor::requestReset(Reset why) {
  std::lock_guard<std::mutex> lock(mutex_);
  reset_requested_ = std::max(reset_requested_, why);
}

std::unique_ptr<PreparedFrame> FrameProcessor::prepare(const ImageWithInfo& input, Extraction extraction) {
  std::unique_ptr<PreparedFrame> frame;
  double max_gap;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    frame = spare_ ? std::move(spare_) : std::make_unique<PreparedFrame>();
    frame->filter = filter_;
    frame->filled_by = filter_;
    frame->time_budget = 1e-3 * options_.core.max_milliseconds;
    frame->reset = std::exchange(reset_requested_, Reset::kNone);
    max_gap = options_.max_frame_gap;
  }
  preparation_.receive(input, max_gap, *frame);
  if (extraction == Extraction::kNow) preparation_.findFeatures(*frame);
  return frame;
}

ProcessedFrame FrameProcessor::process(std::unique_ptr<PreparedFrame> frame) {
  if (current_) keepSpare(std::move(current_));
  current_ = std::move(frame);
  PreparedFrame& answered = *current_;
  preparation_.findFeatures(answered);
  {
    std::lock_guard<std::mutex> lock(mutex_);
    in_force_ = options_;
  }
  ProcessedFrame processed;
  processed.current = &answered;
  if (!answered.problem.empty()) {
    // The reset that it needs is that of the next usable one.
    reset_pending_ = std::max(reset_pending_, answered.reset);
    if (answered.stamp_verdict != StampVerdict::kOutOfOrder) {
      verdict_pending_ = std::max(verdict_pending_, answered.stamp_verdict);
    }
    processed.status = MatchStats::BAD_IMAGE;
    processed.text = "image on " + image_topic_ + " not used: " + answered.problem;
  } else {
    answered.reset = std::max(answered.reset, std::exchange(reset_pending_, Reset::kNone));
    answered.stamp_verdict = std::max(answered.stamp_verdict, std::exchange(verdict_pending_, StampVerdict::kInOrder));
    if (answered.pair_reference) {
      processPair(processed);
    } else {
      processStream(processed);
    }
    if (!answered.mask_problem.empty()) processed.text += "; no mask: " + answered.mask_problem;
  }
  processed.oldest_reference = oldestReference();
  // Frames outlive options; three of them would keep three filters that are no longer in force, megabytes each.
  answered.filter.reset();
  return processed;
}

void FrameProcessor::passOver(std::unique_ptr<PreparedFrame> frame) {
  frame->filter.reset();
  keepSpare(std::move(frame));
}

void FrameProcessor::keepSpare(std::unique_ptr<PreparedFrame> frame) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (frame->filled_by.lock() == filter_) spare_ = std::move(frame);
  }
  if (!frame) return;
  frame.reset();
  giveBackMemory();
}

void FrameProcessor::processStream(ProcessedFrame& processed) {
  const double interval = current_->stamp() - std::exchange(last_stamp_, current_->stamp());
  if (reenter(processed)) return;
  const bool compared = !startAnew(*current_, processed);
  if (compared) {
    compare(processed);
    // It would make the next one fail too; the one before it is the better reference.
    if (isUseless(processed)) {
      if (!mayReenter(*current_)) return;
      retireReference();
      recovery_.miss();
      return;
    }
    processed.reference_held = holdReference(processed, interval);
    if (processed.reference_held) return;
  }
  advance(processed, compared);
}

void FrameProcessor::processPair(ProcessedFrame& processed) {
  reference_ = std::move(current_->pair_reference);
  past_ = Past();
  tracks_.reset();
  if (current_->reset != Reset::kNone) processed.continuity = Continuity::kRestarted;
  const cv::Size before = reference_->frame.features.image_size, now = current_->frame.features.image_size;
  if (before != now) {
    processed.status = MatchStats::BAD_IMAGE;
    processed.text = "the two images differ in size: " + sizeText(before) + " and " + sizeText(now);
    return;
  }
  compare(processed);
  if (current_->reset != Reset::kNone) processed.text = explain(current_->reset) + "; " + processed.text;
}

bool FrameProcessor::startAnew(const PreparedFrame& frame, ProcessedFrame& processed) {
  const auto start = [&](uint8_t status, Continuity continuity, const std::string& why) {
    processed.status = status;
    processed.continuity = continuity;
    processed.text = continuity == Continuity::kContinuous ? why : why + "; this image is a new reference";
    reference_.reset();
    recovery_.clear();
    tracks_.reset();
    pair_pose_.reset();
    past_ = Past();
    return true;
  };
  constexpr uint8_t kFirst = MatchStats::FIRST_FRAME, kTime = MatchStats::TIME_RESET;
  if (frame.reset != Reset::kNone) return start(kFirst, Continuity::kRestarted, explain(frame.reset));
  const auto verdict = frame.stamp_verdict;
  if (verdict == StampVerdict::kClockReset) return start(kTime, Continuity::kRestarted, "the clock went back");
  if (verdict == StampVerdict::kJumpedBack) return start(kTime, Continuity::kRestarted, "the stamps went back");
  const std::string max_gap = "~max_frame_gap (" + secondsText(in_force_.max_frame_gap) + ")";
  if (verdict == StampVerdict::kGap) {
    return start(kTime, Continuity::kBroken,
                 "more than " + max_gap + " since the image before; raise it for a slow camera");
  }
  if (!reference_ && retired_) {
    return start(kTime, Continuity::kBroken,
                 "no image from before the loss is kept any more: they are of another size, or older than "
                 "~max_recovery_gap (" +
                     secondsText(in_force_.recovery.seconds) + ")");
  }
  if (!reference_) return start(kFirst, Continuity::kContinuous, "first image; nothing to compare with yet");
  const cv::Size before = reference_->frame.features.image_size, now = frame.frame.features.image_size;
  if (now != before) {
    return start(kFirst, Continuity::kBroken,
                 "the image size changed from " + sizeText(before) + " to " + sizeText(now));
  }
  if (frame.stamp() - reference_->stamp() <= in_force_.max_frame_gap) return false;
  return start(kTime, Continuity::kBroken,
               "the last usable image is older than " + max_gap + "; raise it for a slow camera");
}

bool FrameProcessor::holdReference(const ProcessedFrame& processed, double interval) {
  if (processed.status != MatchStats::LOW_PARALLAX || processed.result == nullptr || !in_force_.hold_reference)
    return false;
  // Standing still for long, the reference would grow too old to be compared with the next image.
  const double age = current_->stamp() - reference_->stamp();
  if (age + kLateImage * interval > in_force_.max_frame_gap) return false;
  // Turning on, the reference would leave the view before there is parallax; so only while it is well seen.
  return processed.result->inliers >= kWellSeen * processed.result->keypoints_reference;
}

void FrameProcessor::advance(const ProcessedFrame& processed, bool compared) {
  if (compared) {
    keepReference(processed);
    tracks_.advance();
    pair_pose_.advance();
  }
  // After the swap the old reference, if it is not kept, rests in `current_`, alive until the next call.
  std::swap(reference_, current_);
  if (!current_) current_ = std::move(dropped_);
  retired_ = false;
}

void FrameProcessor::compare(ProcessedFrame& processed) {
  processed.reference = reference_.get();
  processed.result = &result_;
  const auto work = [&] {
    std::string without_prior;
    std::optional<RotationPrior> prior;
    if (priors_) prior = priors_->rotation(reference_->header, current_->header, without_prior);
    match(*reference_, result_, prior ? &*prior : nullptr, &past_);
    if (priors_ && result_.robust.pose_found) priors_->learn(result_.robust);
    conclude(processed);
    if (!without_prior.empty()) processed.text += "; " + without_prior;
  };
  guarded(work, [&](const std::string& what) { fail(what, processed); });
}

void FrameProcessor::match(PreparedFrame& reference, MatchResult& result, const RotationPrior* prior, Past* past) {
  adoptCalibration(reference);
  current_->filter->setCamera(current_->camera->camera);
  current_->filter->filter(reference.frame, current_->frame, result, prior, past);
}

void FrameProcessor::adoptCalibration(PreparedFrame& reference) const {
  if (!reference.camera || reference.camera == current_->camera) return;
  const Camera &before = reference.camera->camera, &now = current_->camera->camera;
  if (!before.calibrated() || !now.calibrated() || before == now) return;
  // The depth image stays as it is.
  if (!reference.depth.empty()) reference.stereo.depth = keypointDepth(reference.frame.features, reference.depth);
  for (cv::KeyPoint& keypoint : reference.frame.features.keypoints) {
    const cv::Point2f pixel = pixelOf(now, rayOf(before, keypoint.pt));
    if (std::isfinite(pixel.x) && std::isfinite(pixel.y)) keypoint.pt = pixel;
  }
  reference.camera = current_->camera;
}

void FrameProcessor::conclude(ProcessedFrame& processed) {
  processed.status = static_cast<uint8_t>(result_.status);
  processed.text = explain(result_.status, result_, *current_);
  tracks_.link(result_);
  processed.track_ids = &tracks_.ids();
  processed.track_lengths = &tracks_.lengths();
  pair_pose_.finish(in_force_.sigma_floor, processed);
}

void FrameProcessor::fail(const std::string& what, ProcessedFrame& processed) {
  result_.clear(Status::kRansacFailed);
  past_ = Past();
  tracks_.reset();
  pair_pose_.reset();
  processed.status = MatchStats::RANSAC_FAILED;
  processed.text = what;
}

bool FrameProcessor::reenter(ProcessedFrame& processed) {
  const PreparedFrame& frame = *current_;
  recovery_.setOptions(in_force_.recovery);
  if (!mayReenter(frame)) return false;
  const bool late = frame.stamp_verdict == StampVerdict::kGap ||
                    (reference_ && frame.stamp() - reference_->stamp() > in_force_.max_frame_gap);
  if (late && reference_) retireReference();
  recovery_.giveUpAt(frame.stamp());
  if (!recovery_.lost()) return false;
  const PreparedFrame& newest = *recovery_.kept().front().frame;
  if (frame.frame.features.image_size != newest.frame.features.image_size) return false;

  ProcessedFrame answer = processed;
  answer.result = &result_;
  answer.reference = &newest;
  bool answered = true;
  guarded([&] { answered = compareWithKept(answer); }, [&](const std::string& what) { fail(what, answer); });
  if (!answered) return false;
  processed = answer;
  const bool found = answer.recovered;
  processed.recovered = found && answer.poseValid();  // the last gate may have stopped it
  if (!isUseless(processed)) {
    advance(processed, found);
    if (!found) tracks_.reset();
  }
  return true;
}

bool FrameProcessor::mayReenter(const PreparedFrame& frame) const {
  return recovery_.enabled() && frame.camera->camera.calibrated() && frame.reset == Reset::kNone &&
         frame.stamp_verdict <= StampVerdict::kGap;
}

bool FrameProcessor::compareWithKept(ProcessedFrame& processed) {
  const size_t index = findKept();
  if (index == recovery_.kept().size()) {
    recovery_.miss();
    if (reference_) return false;
    tracks_.reset();
    conclude(processed);
    processed.text += "; images from before the loss are kept: " + std::to_string(recovery_.kept().size());
    return true;
  }
  const std::vector<TrackTable::Track> newest = recovery_.kept().front().tracks;
  const int missed = recovery_.missed();
  KeptFrame kept = recovery_.takeOut(index);
  reference_ = std::move(kept.frame);
  past_ = Past();
  tracks_.goBack(kept.tracks, newest);
  pair_pose_.goOnFrom(std::move(kept.scale));
  processed.recovered = true;
  processed.reference = reference_.get();
  conclude(processed);
  std::ostringstream text;
  text << "goes on from the image of " << reference_->header.stamp << ", "
       << secondsText(current_->stamp() - reference_->stamp()) << " and " << missed
       << " lost images ago: " << processed.text;
  processed.text = text.str();
  return true;
}

size_t FrameProcessor::findKept() {
  const auto& kept = recovery_.kept();
  for (size_t index = 0; index < kept.size(); ++index) {
    MatchResult& result = index == 0 ? result_ : kept_result_;
    match(*kept[index].frame, result);
    if (result.status == Status::kOk || result.status == Status::kLowParallax) {
      if (result.inliers >= kSureInliers) {
        if (index > 0) std::swap(result_, kept_result_);
        return index;
      }
      rejectModel(result);
    }
    if (result.status == Status::kTooFewKeypoints) break;
  }
  return kept.size();
}

void FrameProcessor::retireReference() {
  if (!recovery_.lost()) {
    dropped_ = recovery_.keep({std::move(reference_), tracks_.tracks(), pair_pose_.scale()});
    recovery_.lose();
  }
  reference_.reset();
  past_ = Past();
  tracks_.reset();
  pair_pose_.reset();
  retired_ = true;
}

void FrameProcessor::keepReference(const ProcessedFrame& processed) {
  if (!mayReenter(*current_)) return;
  // Blurred images often agree on a little; what is published of such a pair need not be what comes next starts from.
  const bool sure =
      processed.poseValid() && result_.inliers >= kSureInliers && 2 * result_.inliers >= result_.matches_gms;
  if (recovery_.lost()) {
    recovery_.addPair(sure);
    return;
  }
  dropped_ = recovery_.keep({std::move(reference_), tracks_.tracks(), pair_pose_.scale()});
  if (sure || processed.recovered) return;
  recovery_.lose();
  recovery_.miss();
}

double FrameProcessor::oldestReference() const {
  if (!recovery_.enabled()) return ProcessedFrame::kNoReference;
  const double kept = recovery_.kept().empty() ? ProcessedFrame::kNoReference : recovery_.kept().back().frame->stamp();
  return reference_ ? std::min(kept, reference_->stamp()) : kept;
}

}  // namespace gms_ransac
