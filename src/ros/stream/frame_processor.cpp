#include "stream/frame_processor.h"

#include <algorithm>
#include <utility>

#include "parameters/parameter.h"
#include "stream/status_text.h"

namespace gms_ransac {

namespace {

bool isSame(const MatchFilterOptions& a, const MatchFilterOptions& b) {
  return parametersOf(a) == parametersOf(b) && a.extractor.threads == b.extractor.threads &&
         a.matcher_threads == b.matcher_threads;
}

/// The core of `before` if its options are the same, and else a new one, which keeps its
/// estimate of the time that images take where it can. `before` null: there is none.
std::shared_ptr<Core> coreFor(const MatchFilterOptions& options, const Pipeline* before) {
  if (before != nullptr && isSame(before->options.core, options)) return before->core;
  auto core = std::make_shared<Core>(options);
  if (before != nullptr) core->filter.continueBudget(before->filter);
  return core;
}

}  // namespace

FrameProcessor::FrameProcessor(const Parameters& parameters, const std::string& image_topic,
                               const std::string& info_topic, std::shared_ptr<MotionPriors> priors,
                               const std::string& right_topic, const std::string& right_info_topic)
    : image_topic_(image_topic),
      parameters_(parameters),
      priors_(std::move(priors)),
      preparation_(parameters, image_topic, info_topic, right_topic, right_info_topic) {
  stream_.place = MotionIntegrator(parameters.scale == ScaleMode::kFixed ? parameters.fixed_scale : 1);
}

void FrameProcessor::setOptions(const ProcessorOptions& options) {
  std::shared_ptr<Pipeline> before;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    before = pipeline_;
  }
  auto pipeline = std::make_shared<Pipeline>(parameters_, options, coreFor(options.core, before.get()), priors_);
  if (priors_) priors_->setReadout(std::max(0.0, options.core.robust.rolling_shutter_readout));
  std::lock_guard<std::mutex> lock(mutex_);
  pipeline_.swap(pipeline);  // the replaced one ends without the lock
}

void FrameProcessor::requestReset(Reset why) {
  std::lock_guard<std::mutex> lock(mutex_);
  reset_requested_ = std::max(reset_requested_, why);
}

Received FrameProcessor::receive(const ImageWithInfo& input, const Wanted& wanted) {
  std::shared_ptr<Pipeline> pipeline;
  bool resets;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    pipeline = pipeline_;
    resets = reset_requested_ != Reset::kNone;
  }
  Received received = preparation_.receive(input, resets, pipeline->options.max_frame_gap);
  received.image.wanted = wanted;
  received.image.time_budget = 1e-3 * pipeline->options.core.max_milliseconds;
  received.pipeline = std::move(pipeline);
  if (received.problem.empty()) {
    std::lock_guard<std::mutex> lock(mutex_);
    received.image.reset = std::exchange(reset_requested_, Reset::kNone);
  }
  return received;
}

Prepared FrameProcessor::prepare(Received received, bool right_keypoints) {
  received.learned = maskOf(received.image);
  return preparation_.prepare(std::move(received), right_keypoints);
}

LearnedMask FrameProcessor::maskOf(const ReceivedImage& image) {
  std::lock_guard<std::mutex> lock(mutex_);
  const size_t index = prepared_++;
  const bool begins = image.reset != Reset::kNone || restarts(image.stamp_verdict);
  if (begins || image.header.frame_id != frame_id_) first_of_camera_ = index;
  frame_id_ = image.header.frame_id;
  return index < first_of_camera_ + kMaskDelay ? LearnedMask() : masks_[(index - kMaskDelay) % masks_.size()];
}

ProcessedFrame FrameProcessor::process(const Prepared& prepared) {
  ReceivedImage& image = prepared.frame->image;
  ProcessedFrame answer;
  if (prepared.problem.empty()) {
    image.stamp_verdict = std::max(image.stamp_verdict, std::exchange(verdict_pending_, StampVerdict::kInOrder));
    answer = step(*prepared.pipeline, stream_, recovery_, pairs_, prepared.frame);
  } else {
    if (image.stamp_verdict != StampVerdict::kOutOfOrder)
      verdict_pending_ = std::max(verdict_pending_, image.stamp_verdict);
    stream_.copied_seconds += image.copied_seconds;
    requestReset(std::exchange(image.reset, Reset::kNone));
    answer.current = prepared.frame;
    answer.status = MatchStats::BAD_IMAGE;
    answer.reasons = {{Why::kUnusable, image_topic_ + " not used: " + prepared.problem}};
  }
  answer.text = words(answer, prepared.pipeline->options);
  std::lock_guard<std::mutex> lock(mutex_);
  masks_[answered_++ % masks_.size()] = stream_.past.mask;
  return answer;
}

void FrameProcessor::setPlace(const Eigen::Isometry3d& pose, const Matrix6d& covariance) {
  stream_.place.set(pose, covariance);
  recovery_.clear();
}

}  // namespace gms_ransac
