#include "stream/prepared_frame.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "frames.h"
#include "guard.h"
#include "input/compressed_image.h"
#include "input/image_copies.h"
#include "input/keypoints_conversion.h"
#include "scale/depth_pose.h"
#include "stream/stream.h"
#include "text.h"

namespace gms_ransac {

namespace {

using Clock = std::chrono::steady_clock;

void addDoubt(const std::string& more, PreparedFrame& frame) {
  if (!frame.doubt.empty() && !more.empty()) frame.doubt += "; ";
  frame.doubt += more;
}

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace

FramePreparation::FramePreparation(const Parameters& parameters, const std::string& image_topic,
                                   const std::string& info_topic, const std::string& right_topic,
                                   const std::string& right_info_topic)
    : parameters_(parameters),
      camera_source_(parameters, image_topic, info_topic),
      mask_source_(parameters),
      stereo_depth_(parameters, right_topic, right_info_topic) {}

void FramePreparation::receive(const ImageWithInfo& input, bool resets, PreparedFrame& frame) {
  frame.input = input;
  frame.extracted = false;
  frame.depth.release();
  frame.depth_wanted = true;
  frame.depth_problem.clear();
  frame.stereo.clear();
  frame.mask.release();
  frame.mask_problem.clear();
  frame.pair_reference.reset();
  frame.doubt.clear();
  frame.stamp_verdict = StampVerdict::kInOrder;
  frame.copied_seconds = 0;
  const auto work = [&] {
    if (!convert(frame.input.image, frame)) return;
    if (input.reference) {
      frame.pair_reference = std::make_shared<PreparedFrame>();
      frame.pair_reference->input.image = input.reference;
      frame.pair_reference->input.mask = input.mask;
      if (!convert(frame.pair_reference->input.image, *frame.pair_reference)) {
        frame.problem = frame.pair_reference->problem;
      }
      if (frame.problem.empty()) refuseCopy(frame.pair_reference->input.image, nullptr, frame);
    } else {
      const double before = stamps_.previousStamp();
      classifyStamp(frame);
      if (frame.problem.empty()) {
        // A loop may begin as it ended.
        const bool begins = resets || frame.stamp_verdict > StampVerdict::kSteppedBack;
        if (!begins) refuseCopy(image_before_, keypoints_before_, frame);
        if (!frame.problem.empty()) frame.copied_seconds = std::max(0.0, frame.stamp() - before);
        image_before_ = frame.input.image;
        keypoints_before_ = input.keypoints;
      }
    }
    if (!frame.problem.empty()) return;
    frame.camera = camera_source_.get(input.camera_info, frame.imageSize());
    frame.doubt = frame.camera->doubt;
  };
  guarded(work, [&](const std::string& what) { frame.problem = what; });
}

bool FramePreparation::convert(sensor_msgs::ImageConstPtr& image, PreparedFrame& frame) {
  frame.header = image->header;
  frame.header.frame_id = withoutLeadingSlash(frame.header.frame_id);
  frame.frame.detect_seconds = 0;
  const auto start = Clock::now();
  if (frame.input.keypoints) {
    takeKeypoints(*frame.input.keypoints, frame);
  } else {
    frame.problem = decompress(image);
    if (frame.problem.empty()) frame.problem = toGrey(*image, frame.grey, &frame.values);
  }
  frame.convert_seconds = secondsSince(start);
  frame.frame.seconds_before = frame.convert_seconds;
  return frame.problem.empty();
}

void FramePreparation::takeKeypoints(const Keypoints& keypoints, PreparedFrame& frame) {
  frame.grey.release();
  frame.values.reset();
  frame.problem = toFeatures(keypoints, frame.frame.features);
  frame.frame.features_asked = frame.frame.features.size();
  if (parameters_.scale == ScaleMode::kDepth && frame.problem.empty()) frame.stereo.depth = depthOf(keypoints);
}

void FramePreparation::classifyStamp(PreparedFrame& frame) {
  const double late = stamps_.previousStamp() - frame.stamp();
  frame.stamp_verdict =
      stamps_.judge(frame.stamp(), frame.input.received.toSec(), frame.pipeline->options.max_frame_gap);
  if (frame.stamp_verdict != StampVerdict::kOutOfOrder) return;
  frame.problem = late == 0
                      ? "the stamp is the same as that of the image before it: out of order; if all images have "
                        "this stamp, the camera driver does not set it"
                      : "the stamp is " + secondsText(late) + " older than that of the image before it: out of order";
}

void FramePreparation::refuseCopy(const sensor_msgs::ImageConstPtr& before, const KeypointsConstPtr& keypoints_before,
                                  PreparedFrame& frame) {
  const ImageWithInfo& input = frame.input;
  std::string part;
  if (input.keypoints && keypoints_before) part = copiedPart(*keypoints_before, *input.keypoints);
  if (!input.keypoints && before) part = copiedPart(*before, *input.image);
  if (part.empty()) return;
  frame.problem = part +
                  ", which measures nothing: its driver sends images twice, or the camera is frozen; a simulated "
                  "camera needs noise to be seen at rest";
}

void FramePreparation::findFeatures(PreparedFrame& frame) {
  if (frame.extracted || !frame.problem.empty()) return;
  frame.extracted = true;
  const auto work = [&] {
    std::lock_guard<std::mutex> lock(features_mutex_);
    if (frame.pair_reference) extract(frame.pipeline->filter, *frame.pair_reference);
    extract(frame.pipeline->filter, frame);
    findDepth(frame);
    addDoubt(doubtOfDepth(frame), frame);
  };
  guarded(work, [&](const std::string& what) { frame.problem = what; });
}

void FramePreparation::extract(MatchFilter& filter, PreparedFrame& frame) {
  frame.mask_problem = mask_source_.get(frame.input.mask, frame.imageSize(), frame.mask);
  if (frame.input.keypoints) {
    dropMasked(frame.mask, frame.frame.features, frame.stereo.depth);
    frame.frame.stamp = frame.stamp();
    return;
  }
  filter.extract(frame.grey, frame.frame, frame.mask, frame.stamp());
}

void FramePreparation::findDepth(PreparedFrame& frame) {
  ImageWithInfo& input = frame.input;
  const bool stereo = parameters_.input == InputKind::kStereo;
  const std::string defect = decompress(stereo ? input.right : input.depth);
  if (!defect.empty()) {
    frame.depth_problem = (stereo ? "the right image: " : "the depth image: ") + defect;
  } else if (stereo) {
    findStereoDepth(frame);
  } else if (input.keypoints) {
    const bool missing = parameters_.scale == ScaleMode::kDepth && frame.stereo.depth.empty();
    if (missing) frame.depth_problem = "the keypoints have no depth";
  } else if (input.depth) {
    frame.depth_problem = toDepth(*input.depth, frame.grey.size(), frame.depth);
    frame.stereo.depth = keypointDepth(frame.frame.features, frame.depth);
  } else if (parameters_.scale == ScaleMode::kDepth) {
    frame.depth_problem = "no depth image with about the stamp of the image came";
  }
}

void FramePreparation::findStereoDepth(PreparedFrame& frame) {
  frame.depth_problem = stereo_depth_.take(frame.input, frame.frame.features, *frame.camera, frame.stereo);
  if (!frame.depth_problem.empty()) return;
  if (!frame.depth_wanted) {
    frame.depth_problem = "only features have a subscriber";
    return;
  }
  const auto start = Clock::now();
  frame.depth_problem = stereo_depth_.fill(frame.frame.features, frame.grey, *frame.camera, frame.stereo);
  addDoubt(frame.depth_problem, frame);
  frame.frame.detect_seconds += secondsSince(start);
}

std::string FramePreparation::doubtOfDepth(const PreparedFrame& frame) const {
  if (!frame.depth.empty()) return doubtOfUnit(frame.depth);
  if (parameters_.input != InputKind::kStereo) return doubtOfUnit(cv::Mat(frame.stereo.depth));
  if (frame.stereo.rig && !frame.stereo.rig->doubt.empty()) return frame.stereo.rig->doubt;
  return frame.stereo.right_camera ? frame.stereo.right_camera->doubt : std::string();
}

void PreparedFrame::dropPixels() {
  input = ImageWithInfo();
  for (cv::Mat* pixels : {&grey, &depth, &mask, &stereo.right}) pixels->release();
  stereo.right_ray.clear();
  stereo.rig.reset();
}

std::shared_ptr<PreparedFrame> FramePool::take() {
  std::unique_ptr<PreparedFrame> frame;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (!spare_.empty()) {
      frame = std::move(spare_.back());
      spare_.pop_back();
    }
  }
  if (!frame) frame = std::make_unique<PreparedFrame>();
  return {frame.release(), [pool = weak_from_this()](PreparedFrame* used) {
            std::unique_ptr<PreparedFrame> owned(used);
            if (const auto alive = pool.lock()) alive->give(std::move(owned));
          }};
}

void FramePool::give(std::unique_ptr<PreparedFrame> frame) {
  frame->dropPixels();
  frame->pair_reference.reset();
  frame->pipeline.reset();
  std::lock_guard<std::mutex> lock(mutex_);
  spare_.push_back(std::move(frame));
}

}  // namespace gms_ransac
