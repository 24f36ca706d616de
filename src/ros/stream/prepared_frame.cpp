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

/// Why an image or its keypoints that repeat those before them are not used; empty: they do not. Null: there are none.
template <typename Message>
std::string copyProblem(const boost::shared_ptr<const Message>& before, const boost::shared_ptr<const Message>& now) {
  std::string part = before && now ? copiedPart(*before, *now) : std::string();
  if (part.empty()) return part;
  return part +
         ", which measures nothing: its driver sends images twice, or the camera is frozen; a simulated "
         "camera needs noise to be seen at rest";
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

Received FramePreparation::receive(const ImageWithInfo& input, bool resets, double max_frame_gap) {
  Received received;
  received.image.input = input;
  received.image.camera = camera_before_;
  guarded([&] { received.problem = check(received, resets, max_frame_gap); },
          [&](const std::string& what) { received.problem = what; });
  return received;
}

std::string FramePreparation::check(Received& received, bool resets, double max_frame_gap) {
  ReceivedImage& image = received.image;
  std::string problem = convert(image, received);
  if (problem.empty() && image.input.reference) {
    received.reference.emplace();
    received.reference->input.image = image.input.reference;
    received.reference->input.mask = image.input.mask;
    problem = convert(*received.reference, received);
    if (problem.empty()) problem = copyProblem(received.reference->input.image, image.input.image);
  } else if (problem.empty()) {
    problem = checkOrder(received, resets, max_frame_gap);
  }
  if (!problem.empty()) return problem;
  const cv::Size size = image.input.keypoints ? received.features.image_size : image.grey.size();
  image.camera = camera_before_ = camera_source_.get(image.input.camera_info, size);
  return problem;
}

std::string FramePreparation::convert(ReceivedImage& image, Received& received) const {
  image.header = image.input.image->header;
  image.header.frame_id = withoutLeadingSlash(image.header.frame_id);
  const auto start = Clock::now();
  const auto& keypoints = image.input.keypoints;
  std::string problem = keypoints ? toFeatures(*keypoints, received.features) : decompress(image.input.image);
  if (problem.empty() && !keypoints) problem = toGrey(*image.input.image, image.grey, &image.values);
  if (problem.empty() && keypoints && parameters_.scale == ScaleMode::kDepth) received.depth = depthOf(*keypoints);
  image.convert_seconds = secondsSince(start);
  return problem;
}

std::string FramePreparation::checkOrder(Received& received, bool resets, double max_frame_gap) {
  ReceivedImage& image = received.image;
  const double late = stamps_.previousStamp() - image.stamp();
  image.stamp_verdict = stamps_.judge(image.stamp(), image.input.received.toSec(), max_frame_gap);
  if (image.stamp_verdict == StampVerdict::kOutOfOrder) {
    return late == 0 ? "the stamp is the same as that of the image before it: out of order; if all images have this "
                       "stamp, the camera driver does not set it"
                     : "the stamp is " + secondsText(late) + " older than that of the image before it: out of order";
  }
  // A loop may begin as it ended.
  const bool begins = resets || restarts(image.stamp_verdict);
  const ImageWithInfo& input = image.input;
  std::string problem;
  if (!begins && input.keypoints) problem = copyProblem(keypoints_before_, input.keypoints);
  if (!begins && !input.keypoints) problem = copyProblem(image_before_, input.image);
  if (!problem.empty()) image.copied_seconds = std::max(0.0, -late);
  image_before_ = input.image;
  keypoints_before_ = input.keypoints;
  received.depth_problem = checkBeside(input, begins);
  return problem;
}

std::string FramePreparation::checkBeside(const ImageWithInfo& input, bool begins) {
  const bool stereo = parameters_.input == InputKind::kStereo;
  const sensor_msgs::ImageConstPtr& beside = stereo ? input.right : input.depth;
  if (!beside) return std::string();
  const sensor_msgs::ImageConstPtr before = std::exchange(beside_before_, beside);
  // One stamp is one message, which may be within the tolerance of two images.
  if (begins || !before || before->header.stamp == beside->header.stamp) return std::string();
  const std::string problem = copyProblem(before, beside);
  return problem.empty() ? problem : (stereo ? "the right image: " : "the depth image: ") + problem;
}

Prepared FramePreparation::prepare(Received received, bool right_keypoints) {
  const bool usable = received.problem.empty();
  const auto frame = usable ? received.pipeline->core->frames->acquire() : std::make_shared<PreparedFrame>();
  frame->image = std::move(received.image);
  if (usable) {
    guarded([&] { findFeatures(received, right_keypoints, *frame); },
            [&](const std::string& what) { received.problem = what; });
  }
  if (usable && !received.problem.empty()) {
    PreparedFrame empty;
    empty.image = std::move(frame->image);
    *frame = std::move(empty);
  }
  return {frame, std::move(received.problem), std::move(received.pipeline)};
}

void FramePreparation::findFeatures(Received& received, bool right_keypoints, PreparedFrame& frame) {
  MatchFilter& filter = received.pipeline->filter;
  frame.doubt = frame.image.camera->doubt;
  if (frame.image.input.keypoints) {
    frame.frame.features = std::move(received.features);
    frame.stereo.depth = std::move(received.depth);
  }
  std::lock_guard<std::mutex> lock(features_mutex_);
  if (received.reference) {
    frame.pair_reference = std::make_shared<PreparedFrame>();
    frame.pair_reference->image = std::move(*received.reference);
    extract(filter, received.learned, *frame.pair_reference);
  }
  extract(filter, received.learned, frame);
  frame.depth_problem = std::move(received.depth_problem);
  addDoubt(frame.depth_problem, frame);
  if (frame.depth_problem.empty()) findDepth(right_keypoints, frame);
  addDoubt(doubtOfDepth(frame), frame);
}

void FramePreparation::extract(MatchFilter& filter, const LearnedMask& learned, PreparedFrame& frame) {
  frame.mask_problem = mask_source_.get(frame.image.input.mask, frame.imageSize(), frame.mask);
  frame.frame.seconds_before = frame.image.convert_seconds;
  if (!frame.image.input.keypoints) {
    const cv::Mat mask = learned.forExtraction(frame.mask, frame.imageSize());
    return filter.extract(frame.image.grey, frame.frame, mask, frame.stamp());
  }
  frame.frame.features_asked = frame.frame.features.size();
  dropMasked(frame.mask, frame.frame.features, frame.stereo.depth);
  frame.frame.stamp = frame.stamp();
}

void FramePreparation::findDepth(bool right_keypoints, PreparedFrame& frame) {
  ImageWithInfo& input = frame.image.input;
  const bool stereo = parameters_.input == InputKind::kStereo;
  const std::string defect = decompress(stereo ? input.right : input.depth);
  if (!defect.empty()) {
    frame.depth_problem = (stereo ? "the right image: " : "the depth image: ") + defect;
  } else if (stereo) {
    findStereoDepth(right_keypoints, frame);
  } else if (input.keypoints) {
    const bool missing = parameters_.scale == ScaleMode::kDepth && frame.stereo.depth.empty();
    if (missing) frame.depth_problem = "the keypoints have no depth";
  } else if (input.depth) {
    frame.depth_problem = toDepth(*input.depth, frame.image.grey.size(), frame.depth);
    frame.stereo.depth = keypointDepth(frame.frame.features, frame.depth);
  } else if (parameters_.scale == ScaleMode::kDepth) {
    frame.depth_problem = "no depth image with about the stamp of the image came";
  }
}

void FramePreparation::findStereoDepth(bool right_keypoints, PreparedFrame& frame) {
  frame.depth_problem =
      stereo_depth_.setRight(frame.image.input, frame.frame.features, *frame.image.camera, frame.stereo);
  if (!frame.depth_problem.empty()) return;
  if (!right_keypoints) {
    frame.depth_problem = "only features have a subscriber";
    return;
  }
  const auto start = Clock::now();
  frame.depth_problem = stereo_depth_.fill(frame.frame.features, frame.image.grey, *frame.image.camera, frame.stereo);
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
  image.input = ImageWithInfo();
  for (cv::Mat* pixels : {&image.grey, &depth, &mask, &stereo.right}) pixels->release();
  stereo.right_ray.clear();
  stereo.rig.reset();
}

std::shared_ptr<PreparedFrame> FramePool::acquire() {
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
            if (const auto alive = pool.lock()) alive->release(std::move(owned));
          }};
}

void FramePool::release(std::unique_ptr<PreparedFrame> frame) {
  frame->dropPixels();
  frame->mask_problem.clear();
  frame->stereo.clear();
  frame->depth_problem.clear();
  frame->doubt.clear();
  frame->pair_reference.reset();
  std::lock_guard<std::mutex> lock(mutex_);
  spare_.push_back(std::move(frame));
}

}  // namespace gms_ransac
