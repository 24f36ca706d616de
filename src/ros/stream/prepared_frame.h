// An image of the stream on its way: what is known of it before it is compared with another.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <std_msgs/Header.h>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/match_filter.h"
#include "input/camera_model.h"
#include "input/image_with_info.h"
#include "input/stamp_watch.h"
#include "input/stereo_depth.h"

namespace gms_ransac {

/// Reason to start anew with an image; the greatest one counts.
enum class Reset : uint8_t {
  kNone,
  kUnsubscribed,  ///< images were not taken for a while: ~pause, or no subscriber
  kRequested      ///< ~reset
};

/// One received image after the part of the work that needs no other image.
struct PreparedFrame {
  ImageWithInfo input;  ///< kept, because `grey` may share its memory
  std_msgs::Header header;
  cv::Mat grey;
  cv::Mat depth;  ///< CV_32FC1 metres; empty: none
  /// With ~input stereo; empty if the right image is unusable. Its depth is also that of an image with registered
  /// depth whose keypoints were moved to another calibration.
  StereoColumns stereo;
  bool depth_wanted = true;   ///< with ~input stereo; else the right image serves ~stereo_features alone
  std::string depth_problem;  ///< why the depth image is not used; empty when it is, or when there is none
  cv::Mat mask;              ///< CV_8UC1, zero where no keypoint is taken; empty: none. May share the memory of `input`
  std::string mask_problem;  ///< why there is no mask although there should be one; empty when there need not be
  Frame frame;
  std::unique_ptr<PreparedFrame> pair_reference;  ///< with ~input pair: what this image is compared with
  std::shared_ptr<const CameraModel> camera;
  std::shared_ptr<MatchFilter> filter;   ///< with the options in force when the image came
  std::weak_ptr<MatchFilter> filled_by;  ///< the same, still once the image is answered: what there is room for
  bool extracted = false;                ///< else the features and their tables are not computed yet
  StampVerdict stamp_verdict = StampVerdict::kFirst;
  Reset reset = Reset::kNone;
  std::string problem;  ///< why the image is not used; empty when it is
  double convert_seconds = 0;
  double time_budget = 0;  ///< ~max_milliseconds in seconds

  double stamp() const { return header.stamp.toSec(); }
};

}  // namespace gms_ransac
