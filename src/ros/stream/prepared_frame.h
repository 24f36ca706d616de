// Image or Keypoints message -> grey image, features, depth: the part of the work that needs no other image.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <std_msgs/Header.h>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/match_filter.h"
#include "input/camera_model.h"
#include "input/image_conversion.h"
#include "input/image_with_info.h"
#include "input/mask_source.h"
#include "input/stamp_watch.h"
#include "input/stereo_depth.h"
#include "parameters.h"

namespace gms_ransac {

struct Pipeline;

/// Reason to start anew with an image; the greatest one counts.
enum class Reset : uint8_t {
  kNone,
  kUnsubscribed,  ///< images were not taken for a while: ~pause, or no subscriber
  kRequested      ///< ~reset
};

/// The outputs that have a subscriber, asked once, when the image comes.
struct Wanted {
  bool features = false, stereo_features = false;
  bool features_alone = false;  ///< no other output: the image may be passed over, so its extraction is put off
  bool points = false;          ///< triangulated inliers
};

/// One received image after the part of the work that needs no other image.
struct PreparedFrame {
  ImageWithInfo input;  ///< kept, because `grey` may share its memory
  std_msgs::Header header;
  cv::Mat grey;                      ///< CV_8UC1; empty with ~input keypoints
  std::optional<ValueRange> values;  ///< of a 16-bit image, those that most grey levels show; none: it has 8 bits
  cv::Mat depth;                     ///< CV_32FC1 metres; empty: none
  /// `right` and what belongs to it with ~input stereo; empty if the right image is unusable. `depth` is that of the
  /// keypoints, whether a depth image or the right camera gives it.
  StereoColumns stereo;
  bool depth_wanted = true;   ///< with ~input stereo; else the right image serves ~stereo_features alone
  std::string depth_problem;  ///< why the depth image is not used; empty when it is, or when there is none
  cv::Mat mask;              ///< CV_8UC1, zero where no keypoint is taken; empty: none. May share the memory of `input`
  std::string mask_problem;  ///< why there is no mask although there should be one; empty when there need not be
  Frame frame;
  std::shared_ptr<PreparedFrame> pair_reference;  ///< with ~input pair: what this image is compared with
  std::shared_ptr<const CameraModel> camera;
  std::string doubt;                   ///< why calibration or units may be wrong, and what to do; empty: no reason
  std::shared_ptr<Pipeline> pipeline;  ///< with the options in force when the image came; null once it is answered
  Wanted wanted;
  bool extracted = false;  ///< else the features and their tables are not computed yet
  StampVerdict stamp_verdict = StampVerdict::kFirst;
  double copied_seconds = 0;  ///< since the image before, which this one repeats; 0: it is a measurement of its own
  Reset reset = Reset::kNone;
  std::string problem;  ///< why the image is not used; empty when it is
  double convert_seconds = 0;
  double time_budget = 0;  ///< ~max_milliseconds in seconds

  cv::Size imageSize() const { return grey.empty() ? frame.features.image_size : grey.size(); }
  double stamp() const { return header.stamp.toSec(); }
  /// Pixels may belong to the driver's buffers; a comparison needs features alone.
  void dropPixels();
};

/// Frames that have served, for the images to come: their columns have room already. May be used from any thread.
class FramePool : public std::enable_shared_from_this<FramePool> {
 public:
  /// A frame that comes back when nobody holds it any more, as long as the pool lives.
  std::shared_ptr<PreparedFrame> take();

 private:
  void give(std::unique_ptr<PreparedFrame> frame);

  std::mutex mutex_;
  std::vector<std::unique_ptr<PreparedFrame>> spare_;
};

/// `receive` on one thread, in the order in which images come; `findFeatures` on any.
class FramePreparation {
 public:
  /// Throws std::invalid_argument with a sentence when ~mask_file cannot be read. The topics appear in messages; those
  /// of the right camera with ~input stereo.
  FramePreparation(const Parameters& parameters, const std::string& image_topic, const std::string& info_topic,
                   const std::string& right_topic, const std::string& right_info_topic);

  /// Conversion, stamp rules, camera: all but the features. `frame` may have served another image; its pipeline is
  /// set already. `resets`: the image is a new beginning, so it may repeat the one before it. Never throws.
  void receive(const ImageWithInfo& input, bool resets, PreparedFrame& frame);
  /// Finds the features of a usable image that has none yet, and what depends on them; sets a problem if that fails.
  void findFeatures(PreparedFrame& frame);

 private:
  /// Decompresses and converts one image; false, with `problem` set, if it is unusable.
  bool convert(sensor_msgs::ImageConstPtr& image, PreparedFrame& frame);
  /// Features, and depth with ~scale depth, of a Keypoints message.
  void takeKeypoints(const Keypoints& keypoints, PreparedFrame& frame);
  /// Sets the verdict, and the problem of an image that is to be dropped.
  void classifyStamp(PreparedFrame& frame);
  /// Sets the problem of an image that repeats `before`; null: there is none.
  static void refuseCopy(const sensor_msgs::ImageConstPtr& before, const KeypointsConstPtr& keypoints_before,
                         PreparedFrame& frame);
  /// Finds the features outside the masked area, or drops given ones inside it.
  void extract(MatchFilter& filter, PreparedFrame& frame);
  /// Depth of the keypoints, from a depth image or the right camera.
  void findDepth(PreparedFrame& frame);
  void findStereoDepth(PreparedFrame& frame);
  /// Returns why the depth cannot be in metres, and what to do; empty: no reason.
  std::string doubtOfDepth(const PreparedFrame& frame) const;

  const Parameters parameters_;
  CameraModelSource camera_source_;
  StampWatch stamps_;
  /// The image before, in order; null: none.
  sensor_msgs::ImageConstPtr image_before_;
  KeypointsConstPtr keypoints_before_;

  std::mutex features_mutex_;  ///< guards what follows
  MaskSource mask_source_;
  StereoDepth stereo_depth_;
};

}  // namespace gms_ransac
