// Shared by the targets that give a stream of images or keypoints to the node's frame processor.
#pragma once

#include <cv_bridge/cv_bridge.h>
#include <opencv2/imgproc.hpp>

#include "fuzz_input.h"
#include "invariants.h"
#include "stream/frame_processor.h"
#include "stream/pair_pose.h"

namespace gms_ransac {

constexpr int kWallWidth = 128, kWallHeight = 96;  // of a view

/// The view of a wall from a camera that moves sideways by up to 255 pixels, as an image message.
inline sensor_msgs::ImagePtr wallView(int shift, int noise = 0) {
  static const cv::Mat wall = [] {
    cv::Mat squares(kWallHeight / 4, (kWallWidth + 256) / 4, CV_8UC1), large;
    cv::RNG(7).fill(squares, cv::RNG::UNIFORM, 0, 256);
    cv::resize(squares, large, cv::Size(), 4, 4, cv::INTER_LINEAR);
    return large;
  }();
  cv::Mat image = wall(cv::Rect(shift, 0, kWallWidth, kWallHeight)).clone();
  cv::Mat grain(image.size(), CV_8UC1);
  cv::RNG(static_cast<uint64_t>(noise)).fill(grain, cv::RNG::UNIFORM, 0, 1 + noise);
  image += grain;
  return cv_bridge::CvImage({}, "mono8", image).toImageMsg();
}

/// An answer has a sentence, the columns of its result agree, and its pose is fit to publish.
inline void demandSound(const ProcessedFrame& processed) {
  demand(!processed.text.empty(), "an answer has a sentence");
  demand(processed.text.size() < 2000, "and a short one");
  if (processed.pair != nullptr && !processed.pair->result.raw.empty()) {
    demandEmpty(brokenResult(processed.pair->reference->frame.features, processed.current->frame.features,
                             processed.pair->result));
  }
  const RelativePose* pose = processed.posePublished();
  if (pose == nullptr) return;
  demandEmpty(brokenPose(*pose, kPublishedRounding));
  demandEmpty(poseDefect(*pose));
}

}  // namespace gms_ransac
