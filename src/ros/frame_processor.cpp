#include "frame_processor.h"

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <utility>

#include <opencv2/core.hpp>

#include "depth_conversion.h"
#include "frames.h"
#include "gms_ransac/keypoint_depth.h"
#include "gms_ransac/rays.h"
#include "guard.h"
#include "quantity_text.h"

namespace gms_ransac {

namespace {

// Share of the reference's keypoints that must be inliers for it to be kept. Successive images of a handheld camera
// have 0.4 to 0.7 (TUM freiburg1, 2000 keypoints), so the view has shifted by about half when it falls below.
constexpr double kWellSeen = 0.2;
// The next image is expected within this many times the interval between the last two.
constexpr double kLateImage = 2;
// After a loss image after image is compared with every kept one, which may show another place: that many tries leave
// more to chance than one pair of neighbours does. Of 5000 pairs of images of different places (four real sets, three
// rendered rooms) 83 pass for the same place, with 17 inliers at most.
constexpr int kSureInliers = 30;

int usedPercent(const cv::Mat& mask) {
  return cvRound(100.0 * cv::countNonZero(mask) / static_cast<double>(mask.total()));
}

/// Why there is a rotation and no translation.
std::string explainLowParallax(const MatchResult& result, const RobustOptions& options) {
  std::ostringstream text;
  text.precision(3);
  text << "the direction of translation cannot be observed: ";
  if (result.robust.ambiguous) {
    text << "another motion explains the " << result.matches_gms
         << " filtered matches as well, or part of them; the rotation is as good as its covariance says";
  } else {
    text << std::fixed << result.robust.median_parallax_px << " px of parallax where keypoints are off by "
         << result.robust.sigma_px << " px; a turn explains the matches as well, or leaves the direction more than "
         << std::defaultfloat << "~max_direction_sigma (" << options.max_direction_sigma << " degrees) uncertain";
  }
  return text.str();
}

/// What ~rolling_shutter_readout could not do for the pair, as the end of a sentence; empty: nothing to say.
std::string explainRows(const RobustResult& result, double readout) {
  const bool unknown = result.row_correction == RowCorrection::kUnknownTime;
  if (!unknown && result.row_correction != RowCorrection::kUnlikely) return std::string();
  return "; its rows count as read at once: " +
         (unknown ? "the images are less than ~rolling_shutter_readout (" + secondsText(readout) + ") apart"
                  : "the matches fit worse with ~rolling_shutter_readout (" + secondsText(readout) + ")");
}

/// The outcome of a comparison in words, with what to do where something can be done.
std::string explain(Status status, const MatchResult& result, const PreparedFrame& current) {
  std::ostringstream text;
  switch (status) {
    case Status::kOk:
      text << result.inliers << " of " << result.matches_gms << " filtered matches agree on one motion";
      break;
    case Status::kTooFewKeypoints:
      text << "only " << result.keypoints_current << " keypoints (the reference has " << result.keypoints_reference
           << "): the image is dark, blurred or plain; lower ~fast_threshold";
      if (!current.mask.empty()) text << "; the mask leaves " << usedPercent(current.mask) << " % of it";
      break;
    case Status::kTooFewMatches:
      text << "only " << result.matches.size() << " matches; raise ~features";
      break;
    case Status::kGmsRejected:
      text << "only " << result.matches_gms << " of " << result.matches.size()
           << " matches have support around them: the views differ too much, or ~features is too small for the grid";
      break;
    case Status::kRansacFailed:
      text << "no model explains the " << result.matches_gms << " filtered matches";
      break;
    case Status::kLowParallax:
      text << explainLowParallax(result, current.filter->options().robust);
      break;
    case Status::kUncalibrated:
      text << "correspondences only, no pose: " << current.camera->problem;
      break;
    default:
      text << toString(status);
  }
  text << explainRows(result.robust, current.filter->options().robust.rolling_shutter_readout);
  return text.str();
}

/// Without keypoints nothing can be compared with the image.
bool isUseless(const ProcessedFrame& processed) {
  return processed.status == MatchStats::TOO_FEW_KEYPOINTS &&
         processed.current->frame.features.size() < kMinimumMatches;
}

/// No model, as far as anyone is told.
void rejectModel(MatchResult& result) {
  std::replace(result.stage.begin(), result.stage.end(), MatchStage::kInlier, MatchStage::kGms);
  std::fill(result.probability.begin(), result.probability.end(), 0.f);
  result.inliers = 0;
  result.robust.reject();
  result.status = Status::kRansacFailed;
}

/// Of what a filter held, megabytes with many features, the allocator would keep the pages for the thread that asked
/// for them, and a process whose options change now and then would grow.
void giveBackMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace

static_assert(static_cast<int>(Status::kUncalibrated) == MatchStats::UNCALIBRATED,
              "values of the core and the message");

std::string statusName(uint8_t status) {
  if (status == MatchStats::TIME_RESET) return "TIME_RESET";
  if (status == MatchStats::BAD_IMAGE) return "BAD_IMAGE";
  if (status == MatchStats::RECOVERED) return "RECOVERED";
  return toString(static_cast<Status>(status));
}

FrameProcessor::FrameProcessor(const Parameters& parameters, const std::string& image_topic,
                               const std::string& info_topic, std::shared_ptr<MotionPriors> priors,
                               const std::string& right_topic, const std::string& right_info_topic)
    : image_topic_(image_topic),
      parameters_(parameters),
      priors_(std::move(priors)),
      camera_source_(parameters, image_topic, info_topic),
      mask_source_(parameters),
      stereo_depth_(parameters, right_topic, right_info_topic) {}

void FrameProcessor::setOptions(const ProcessorOptions& options) {
  const auto end = [](MatchFilter* replaced) {
    delete replaced;
    giveBackMemory();
  };
  std::shared_ptr<MatchFilter> filter(new MatchFilter(options.core), end);
  if (priors_) priors_->setReadout(options.core.robust.rolling_shutter_readout);
  std::lock_guard<std::mutex> lock(mutex_);
  filter_.swap(filter);  // the replaced one ends without the lock
  options_ = options;
}

ProcessorOptions FrameProcessor::options() {
  std::lock_guard<std::mutex> lock(mutex_);
  return options_;
}

void FrameProcessor::requestReset() {
  std::lock_guard<std::mutex> lock(mutex_);
  reset_requested_ = true;
}

std::unique_ptr<PreparedFrame> FrameProcessor::prepare(const ImageWithInfo& input, Extraction extraction) {
  auto frame = beginFrame(input);
  guarded([&] { receive(*frame); }, [&](const std::string& what) { frame->problem = what; });
  if (extraction == Extraction::kNow) findFeatures(*frame);
  return frame;
}

std::unique_ptr<PreparedFrame> FrameProcessor::beginFrame(const ImageWithInfo& input) {
  std::unique_ptr<PreparedFrame> frame;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    frame = spare_ ? std::move(spare_) : std::make_unique<PreparedFrame>();
    frame->filter = filter_;
    frame->time_budget = 1e-3 * options_.core.max_milliseconds;
    frame->reset_requested = std::exchange(reset_requested_, false);
  }
  frame->input = input;
  frame->extracted = false;
  frame->depth.release();
  frame->depth_problem.clear();
  frame->stereo.clear();
  frame->mask.release();
  frame->mask_problem.clear();
  frame->pair_reference.reset();
  frame->stamp_verdict = StampVerdict::kInOrder;
  return frame;
}

void FrameProcessor::receive(PreparedFrame& frame) {
  const ImageWithInfo& input = frame.input;
  if (!convert(input.image, frame)) return;
  if (input.reference) {
    frame.pair_reference = std::make_unique<PreparedFrame>();
    frame.pair_reference->input.image = input.reference;
    frame.pair_reference->input.mask = input.mask;
    if (!convert(input.reference, *frame.pair_reference)) {
      frame.problem = frame.pair_reference->problem;
      return;
    }
  } else {
    frame.problem = classifyStamp(frame);
    if (!frame.problem.empty()) return;
  }
  frame.camera = camera_source_.get(input.camera_info, frame.grey.size());
}

void FrameProcessor::findFeatures(PreparedFrame& frame) {
  if (frame.extracted || !frame.problem.empty()) return;
  frame.extracted = true;
  const auto work = [&] {
    std::lock_guard<std::mutex> lock(features_mutex_);
    if (frame.pair_reference) extract(*frame.filter, *frame.pair_reference);
    extract(*frame.filter, frame);
    findDepth(frame);
  };
  guarded(work, [&](const std::string& what) { frame.problem = what; });
}

void FrameProcessor::findDepth(PreparedFrame& frame) {
  const ImageWithInfo& input = frame.input;
  if (parameters_.input == InputKind::kStereo) {
    frame.depth_problem = stereo_depth_.fill(input, frame.frame.features, *frame.camera, *frame.filter, frame.stereo);
    if (frame.depth_problem.empty()) frame.frame.detect_seconds += stereo_depth_.detectSeconds();
  } else if (input.depth) {
    frame.depth_problem = toDepth(*input.depth, frame.grey.size(), frame.depth);
  } else if (parameters_.scale == ScaleMode::kDepth) {
    frame.depth_problem = "no depth image of about its stamp came with the image";
  }
}

void FrameProcessor::extract(MatchFilter& filter, PreparedFrame& frame) {
  frame.mask_problem = mask_source_.get(frame.input.mask, frame.grey.size(), frame.mask);
  filter.extract(frame.grey, frame.frame, frame.mask, frame.stamp());
}

std::string FrameProcessor::classifyStamp(PreparedFrame& frame) {
  const double late = stamps_.previousStamp() - frame.stamp();
  frame.stamp_verdict = stamps_.judge(frame.stamp(), frame.input.received.toSec(), options().max_frame_gap);
  if (frame.stamp_verdict != StampVerdict::kOutOfOrder) return std::string();
  if (late == 0) {
    return "the stamp is the same as that of the image before it; the image is dropped as out of order. Do all images "
           "have this stamp, the camera driver does not set it";
  }
  return "the stamp is " + secondsText(late) +
         " before that of the image before it; the image is dropped as out of order";
}

bool FrameProcessor::convert(const sensor_msgs::ImageConstPtr& image, PreparedFrame& frame) {
  frame.header = image->header;
  frame.header.frame_id = withoutLeadingSlash(frame.header.frame_id);
  frame.frame.detect_seconds = 0;
  const auto start = std::chrono::steady_clock::now();
  frame.problem = converter_.toGrey(*image, frame.grey);
  frame.convert_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  frame.frame.seconds_before = frame.convert_seconds;
  return frame.problem.empty();
}

ProcessedFrame FrameProcessor::process(std::unique_ptr<PreparedFrame> frame) {
  if (current_) {
    std::lock_guard<std::mutex> lock(mutex_);
    spare_ = std::move(current_);
  }
  current_ = std::move(frame);
  PreparedFrame& answered = *current_;
  findFeatures(answered);
  ProcessedFrame processed = answer();
  // Frames outlive options; three of them would keep three filters that are no longer in force, megabytes each.
  answered.filter.reset();
  return processed;
}

void FrameProcessor::passOver(std::unique_ptr<PreparedFrame> frame) {
  frame->filter.reset();
  std::lock_guard<std::mutex> lock(mutex_);
  spare_ = std::move(frame);
}

ProcessedFrame FrameProcessor::answer() {
  ProcessedFrame processed;
  processed.current = current_.get();
  if (!current_->problem.empty()) {
    keepPending(*current_);
    processed.status = MatchStats::BAD_IMAGE;
    processed.text = "image on " + image_topic_ + " not used: " + current_->problem;
    processed.oldest_reference = oldestReference();
    return processed;
  }
  takePending(*current_);
  processed = current_->pair_reference ? processPair(processed) : processStream(processed);
  const std::string& problem = processed.current->mask_problem;
  if (!problem.empty()) processed.text += "; no mask: " + problem;
  processed.oldest_reference = oldestReference();
  return processed;
}

void FrameProcessor::keepPending(const PreparedFrame& frame) {
  reset_pending_ |= frame.reset_requested;
  if (frame.stamp_verdict != StampVerdict::kOutOfOrder) {
    verdict_pending_ = std::max(verdict_pending_, frame.stamp_verdict);
  }
}

void FrameProcessor::takePending(PreparedFrame& frame) {
  frame.reset_requested |= std::exchange(reset_pending_, false);
  frame.stamp_verdict = std::max(frame.stamp_verdict, std::exchange(verdict_pending_, StampVerdict::kInOrder));
}

ProcessedFrame FrameProcessor::processStream(ProcessedFrame processed) {
  const double interval = current_->stamp() - std::exchange(last_stamp_, current_->stamp());
  if (reenter(processed)) return processed;
  processed.text = startAnew(*current_, processed);
  const bool compared = processed.text.empty();
  if (compared) {
    compare(processed);
    // It would make the next one fail too; the one before it is the better reference.
    if (isUseless(processed)) {
      if (!mayReenter(*current_)) return processed;
      retireReference();
      recovery_.miss();
      return processed;
    }
    processed.reference_held = holdReference(processed, interval);
    if (processed.reference_held) return processed;
  }
  advance(processed, compared);
  return processed;
}

ProcessedFrame FrameProcessor::processPair(ProcessedFrame processed) {
  reference_ = std::move(current_->pair_reference);
  tracks_.reset();
  if (current_->reset_requested) processed.continuity = Continuity::kRestarted;
  if (reference_->frame.features.image_size != current_->frame.features.image_size) {
    processed.status = MatchStats::BAD_IMAGE;
    processed.text = "the two images differ in size: " + sizeText(reference_->frame.features.image_size) + " and " +
                     sizeText(current_->frame.features.image_size);
    return processed;
  }
  compare(processed);
  if (current_->reset_requested) processed.text = "reset on request; " + processed.text;
  return processed;
}

void FrameProcessor::advance(const ProcessedFrame& processed, bool compared) {
  if (compared) {
    keepReference(processed);
    tracks_.advance();
    if (scale_updated_) {
      propagator_.advance();
    } else {
      propagator_.reset();
    }
  }
  // After the swap the old reference, if it is not kept, rests in `current_`, alive until the next call.
  std::swap(reference_, current_);
  if (!current_) current_ = std::move(dropped_);
  retired_ = false;
}

std::string FrameProcessor::startAnew(const PreparedFrame& frame, ProcessedFrame& processed) {
  processed.status = MatchStats::TIME_RESET;
  processed.continuity = Continuity::kBroken;
  const std::string anew = "; this image is a new reference";
  std::string why;
  const double max_gap = options().max_frame_gap;
  if (frame.reset_requested) {
    processed.status = MatchStats::FIRST_FRAME;
    processed.continuity = Continuity::kRestarted;
    why = "reset on request" + anew;
  } else if (frame.stamp_verdict == StampVerdict::kClockReset) {
    processed.continuity = Continuity::kRestarted;
    why = "the clock went back" + anew;
  } else if (frame.stamp_verdict == StampVerdict::kJumpedBack) {
    processed.continuity = Continuity::kRestarted;
    why = "the stamps went back" + anew;
  } else if (frame.stamp_verdict == StampVerdict::kGap) {
    why = "more than ~max_frame_gap (" + secondsText(max_gap) + ") since the image before" + anew;
  } else if (!reference_ && retired_) {
    why = "it follows on no image from before the loss: they are of another size, or older than ~max_recovery_gap (" +
          secondsText(options().recovery.seconds) + ")" + anew;
  } else if (!reference_) {
    processed.status = MatchStats::FIRST_FRAME;
    processed.continuity = Continuity::kContinuous;
    return "first image; nothing to compare with yet";
  } else if (frame.frame.features.image_size != reference_->frame.features.image_size) {
    processed.status = MatchStats::FIRST_FRAME;
    why = "the image size changed from " + sizeText(reference_->frame.features.image_size) + " to " +
          sizeText(frame.frame.features.image_size) + anew;
  } else if (frame.stamp() - reference_->stamp() > max_gap) {
    why = "the last usable image is older than ~max_frame_gap (" + secondsText(max_gap) + ")" + anew;
  } else {
    processed.continuity = Continuity::kContinuous;
    return std::string();
  }
  reference_.reset();
  recovery_.clear();
  tracks_.reset();
  propagator_.reset();
  frame.filter->reset();
  return why;
}

void FrameProcessor::compare(ProcessedFrame& processed) {
  processed.reference = reference_.get();
  processed.result = &result_;
  const auto work = [&] {
    const std::string without_prior = matchWithPriors();
    conclude(processed);
    processed.text += without_prior;
  };
  guarded(work, [&](const std::string& what) { fail(what, processed); });
}

void FrameProcessor::fail(const std::string& what, ProcessedFrame& processed) {
  result_.clear(Status::kRansacFailed);
  tracks_.reset();
  processed.status = MatchStats::RANSAC_FAILED;
  processed.text = what;
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

void FrameProcessor::match(PreparedFrame& reference, MatchResult& result, const RotationPrior* prior) {
  adoptCalibration(reference);
  current_->filter->setCamera(current_->camera->camera);
  current_->filter->filter(reference.frame, current_->frame, result, prior);
}

void FrameProcessor::conclude(ProcessedFrame& processed) {
  processed.status = static_cast<uint8_t>(result_.status);
  processed.text = explain(result_.status, result_, *current_);
  tracks_.link(result_);
  processed.track_ids = &tracks_.ids();
  processed.track_lengths = &tracks_.lengths();
  scale_updated_ = false;
  finishPose(processed);
}

bool FrameProcessor::mayReenter(const PreparedFrame& frame) const {
  return recovery_.enabled() && frame.camera->camera.calibrated() && !frame.reset_requested &&
         frame.stamp_verdict <= StampVerdict::kGap;
}

bool FrameProcessor::reenter(ProcessedFrame& processed) {
  const PreparedFrame& frame = *current_;
  const ProcessorOptions options = this->options();
  recovery_.setOptions(options.recovery);
  if (!mayReenter(frame)) return false;
  const bool late = frame.stamp_verdict == StampVerdict::kGap ||
                    (reference_ && frame.stamp() - reference_->stamp() > options.max_frame_gap);
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

bool FrameProcessor::compareWithKept(ProcessedFrame& processed) {
  const size_t index = findKept();
  if (index < recovery_.kept().size()) {
    goOnFrom(index, processed);
    return true;
  }
  recovery_.miss();
  if (reference_) return false;
  tracks_.reset();
  conclude(processed);
  processed.text += "; images from before the loss are kept: " + std::to_string(recovery_.kept().size());
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

void FrameProcessor::goOnFrom(size_t index, ProcessedFrame& processed) {
  const std::vector<TrackTable::Track> newest = recovery_.kept().front().tracks;
  const int missed = recovery_.missed();
  KeptFrame kept = recovery_.takeOut(index);
  reference_ = std::move(kept.frame);
  tracks_.goBack(kept.tracks, newest);
  propagator_ = std::move(kept.scale);
  processed.recovered = true;
  processed.reference = reference_.get();
  conclude(processed);
  std::ostringstream text;
  text << "goes on from the image of " << reference_->header.stamp << ", "
       << secondsText(current_->stamp() - reference_->stamp()) << " and " << missed
       << " lost images ago: " << processed.text;
  processed.text = text.str();
}

void FrameProcessor::retireReference() {
  if (!recovery_.lost()) {
    dropped_ = recovery_.keep({std::move(reference_), tracks_.tracks(), propagator_});
    recovery_.lose();
  }
  reference_.reset();
  tracks_.reset();
  propagator_.reset();
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
  dropped_ = recovery_.keep({std::move(reference_), tracks_.tracks(), propagator_});
  if (sure || processed.recovered) return;
  recovery_.lose();
  recovery_.miss();
}

double FrameProcessor::oldestReference() const {
  if (!recovery_.enabled()) return ProcessedFrame::kNoReference;
  const double kept = recovery_.kept().empty() ? ProcessedFrame::kNoReference : recovery_.kept().back().frame->stamp();
  return reference_ ? std::min(kept, reference_->stamp()) : kept;
}

std::string FrameProcessor::matchWithPriors() {
  std::string problem;
  std::optional<RotationPrior> prior;
  if (priors_) prior = priors_->rotation(reference_->header, current_->header, problem);
  match(*reference_, result_, prior ? &*prior : nullptr);
  if (priors_ && result_.robust.pose_found) priors_->learn(result_.robust);
  return problem.empty() ? problem : "; " + problem;
}

void FrameProcessor::measureLength(ProcessedFrame& processed) {
  std::string problem;
  const PairSeen pair = {reference_->header, current_->header,         result_.robust,
                         triangulation_,     current_->camera->camera, {reference_->grey, current_->grey}};
  const ScaleEstimate length = priors_->length(pair, problem);
  processed.metric_scale = length.features > 0 && processed.status == MatchStats::OK;
  if (processed.metric_scale) processed.pose = withLength(processed.pose, length);
  if (!problem.empty()) processed.text += "; no length: " + problem;
}

void FrameProcessor::finishPose(ProcessedFrame& processed) {
  if (!processed.poseValid()) return;
  processed.pose = result_.robust.pose;
  const Camera& camera = current_->camera->camera;
  if (parameters_.scale == ScaleMode::kPropagate || parameters_.measuresMetres()) {
    triangulateInliers(reference_->frame.features, current_->frame.features, result_, camera, triangulation_);
  }
  bool translation_known = processed.status == MatchStats::OK;
  processed.length_missing = processed.recovered && translation_known;
  if (parameters_.scale == ScaleMode::kFixed && translation_known && !processed.recovered) {
    processed.pose = withLength(processed.pose, {parameters_.fixed_scale, 0, 1});
    processed.metric_scale = true;
  } else if (parameters_.scale == ScaleMode::kPropagate && translation_known) {
    const ScaleEstimate scale = propagator_.update(triangulation_, result_, camera, processed.recovered);
    processed.pose = withLength(processed.pose, scale);
    processed.length_missing &= scale.features == 0;
    scale_updated_ = true;
  } else if (parameters_.scale == ScaleMode::kPropagate) {
    propagator_.carryThroughTurn(triangulation_, result_);
    scale_updated_ = true;
  } else if (priors_ && (parameters_.scale == ScaleMode::kOdometry || parameters_.scale == ScaleMode::kGround)) {
    measureLength(processed);
  } else if (parameters_.measuresDepth()) {
    takeDepth(processed, translation_known);
  }
  if (processed.length_missing) processed.text += "; how far the camera moved meanwhile is not known";
  makePublishable(translation_known, options().sigma_floor, processed.pose);
  stopUnfitPose(processed);
}

void FrameProcessor::takeDepth(ProcessedFrame& processed, bool& translation_known) {
  const bool stereo = parameters_.input == InputKind::kStereo;
  const auto depthOf = [stereo](const PreparedFrame& frame) {
    const bool known = stereo || !frame.stereo.depth.empty();
    return known ? frame.stereo.depth : keypointDepth(frame.frame.features, frame.depth);
  };
  const ScaleEstimate scale =
      poseFromKeypointDepth(triangulation_, reference_->frame.features, current_->frame.features, result_,
                            current_->camera->camera, depthOf(*reference_), depthOf(*current_),
                            stereo ? DepthSource::kTriggeredPair : DepthSource::kRollingCamera, processed.pose);
  processed.metric_scale = scale.features > 0;
  processed.length_missing &= !processed.metric_scale;
  if (processed.metric_scale && !translation_known) {
    // Depth makes a translation observable that the images alone do not show.
    processed.status = MatchStats::OK;
    processed.text = explain(Status::kOk, result_, *current_) +
                     "; too little parallax, the translation is that of the " + (stereo ? "two cameras" : "depth");
    translation_known = true;
  }
  if (processed.metric_scale) return;
  const std::string& problem = current_->depth_problem.empty() ? reference_->depth_problem : current_->depth_problem;
  processed.text += "; no length: " + (problem.empty() ? "too few inliers have depth" : problem);
}

void FrameProcessor::stopUnfitPose(ProcessedFrame& processed) {
  const std::string defect = poseDefect(processed.pose);
  if (defect.empty()) return;
  processed.status = MatchStats::RANSAC_FAILED;
  processed.text = "the pose was stopped before it was published: " + defect;
  processed.pose = RelativePose();
  processed.metric_scale = false;
  // What the propagator took from this pair may be as wrong: it starts anew.
  scale_updated_ = false;
}

bool FrameProcessor::holdReference(const ProcessedFrame& processed, double interval) {
  const ProcessorOptions options = this->options();
  if (processed.status != MatchStats::LOW_PARALLAX || processed.result == nullptr || !options.hold_reference)
    return false;
  // Standing still for long, the reference would grow too old to be compared with the next image.
  const double age = current_->stamp() - reference_->stamp();
  if (age + kLateImage * interval > options.max_frame_gap) return false;
  // Turning on, the reference would leave the view before there is parallax; so only while it is well seen.
  return processed.result->inliers >= kWellSeen * processed.result->keypoints_reference;
}

}  // namespace gms_ransac
