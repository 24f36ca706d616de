// Image or Keypoints message -> received: grey, in order, with its camera -> prepared: with features and depth. The
// part of the work that needs no other image.
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

/// One image as it came, in grey.
struct ReceivedImage {
  ImageWithInfo input;  ///< kept, because `grey` may share its memory
  std_msgs::Header header;
  cv::Mat grey;                               ///< CV_8UC1; empty with ~input keypoints
  std::optional<ValueRange> values;           ///< of 16 bits, those that most grey levels show; none: it has 8 bits
  std::shared_ptr<const CameraModel> camera;  ///< of an unusable image that of the one before; null: none yet
  Wanted wanted;
  StampVerdict stamp_verdict = StampVerdict::kInOrder;
  double copied_seconds = 0;  ///< since the image before, which this one repeats; 0: it is a measurement of its own
  Reset reset = Reset::kNone;
  double convert_seconds = 0;
  double time_budget = 0;  ///< ~max_milliseconds in seconds

  double stamp() const { return header.stamp.toSec(); }
};

/// The first stage: an image on its way to its features.
struct Received {
  ReceivedImage image;
  std::optional<ReceivedImage> reference;  ///< with ~input pair: what the image is compared with
  Features features;                       ///< with ~input keypoints
  std::vector<float> depth;                ///< of these; metres, 0 where unknown; empty: none is wanted or known
  std::string depth_problem;           ///< why depth or right image are not used; empty: nothing is known against them
  LearnedMask learned;                 ///< what an earlier pair has shown to be fixed to the camera
  std::string problem;                 ///< why the image is not used; empty: it is
  std::shared_ptr<Pipeline> pipeline;  ///< with the options in force when the image came
};

/// An image and what was found in it; nothing in one that is not used.
struct PreparedFrame {
  ReceivedImage image;
  Frame frame;
  cv::Mat mask;              ///< CV_8UC1, zero where no keypoint is taken; empty: none. May share the memory of `input`
  std::string mask_problem;  ///< why there is no mask although there should be one; empty when there need not be
  cv::Mat depth;             ///< CV_32FC1 metres; empty: none
  /// `right` and what belongs to it with ~input stereo; empty if the right image is unusable. `depth` is that of the
  /// keypoints, whether a depth image or the right camera gives it.
  StereoColumns stereo;
  std::string depth_problem;  ///< why the depth is not used; empty when it is, or when there is none
  std::string doubt;          ///< why calibration or units may be wrong, and what to do; empty: no reason
  std::shared_ptr<PreparedFrame> pair_reference;  ///< with ~input pair: what this image is compared with

  cv::Size imageSize() const { return image.grey.empty() ? frame.features.image_size : image.grey.size(); }
  double stamp() const { return image.stamp(); }
  /// Pixels may belong to the driver's buffers; a comparison needs features alone.
  void dropPixels();
};

/// The second stage: an image on its way to its answer. The frame outlives the options, so it does not hold them.
struct Prepared {
  std::shared_ptr<PreparedFrame> frame;
  std::string problem;  ///< why the image is not used; empty: it is
  std::shared_ptr<Pipeline> pipeline;
};

/// Frames that have served, for the images to come: their columns have room already. May be used from any thread.
class FramePool : public std::enable_shared_from_this<FramePool> {
 public:
  /// An empty frame that comes back when nobody holds it any more, as long as the pool lives.
  std::shared_ptr<PreparedFrame> acquire();

 private:
  void release(std::unique_ptr<PreparedFrame> frame);

  std::mutex mutex_;
  std::vector<std::unique_ptr<PreparedFrame>> spare_;
};

/// `receive` on one thread, in the order in which images come; `prepare` on any. Neither throws.
class FramePreparation {
 public:
  /// Throws std::invalid_argument with a sentence when ~mask_file cannot be read. The topics appear in messages; those
  /// of the right camera with ~input stereo.
  FramePreparation(const Parameters& parameters, const std::string& image_topic, const std::string& info_topic,
                   const std::string& right_topic, const std::string& right_info_topic);

  /// Conversion, stamp rules, camera: all but the features. `resets`: the image is a new beginning, so it may repeat
  /// the one before it. `max_frame_gap`: seconds.
  Received receive(const ImageWithInfo& input, bool resets, double max_frame_gap);
  /// Features of a usable image, and what depends on them. `right_keypoints`: with ~input stereo their depth is wanted.
  Prepared prepare(Received received, bool right_keypoints);

 private:
  // These return why the image is not used; empty: it is.
  std::string check(Received& received, bool resets, double max_frame_gap);
  /// Grey image, or with ~input keypoints features, and their depth with ~scale depth.
  std::string convert(ReceivedImage& image, Received& received) const;
  /// Refuses late images and copies of the image before.
  std::string checkOrder(Received& received, bool resets, double max_frame_gap);
  /// The same of copies for the depth image or, with ~input stereo, the right one. `begins`: it may repeat any.
  std::string checkBeside(const ImageWithInfo& input, bool begins);

  /// Fills a frame that has its image.
  void findFeatures(Received& received, bool right_keypoints, PreparedFrame& frame);
  void extract(MatchFilter& filter, const LearnedMask& learned, PreparedFrame& frame);
  /// Depth of the keypoints, from a depth image or the right camera.
  void findDepth(bool right_keypoints, PreparedFrame& frame);
  void findStereoDepth(bool right_keypoints, PreparedFrame& frame);
  /// Returns why the depth cannot be in metres, and what to do; empty: no reason.
  std::string doubtOfDepth(const PreparedFrame& frame) const;

  const Parameters parameters_;
  CameraModelSource camera_source_;
  StampWatch stamps_;
  // The image before, in order, and its keypoints; null: none.
  sensor_msgs::ImageConstPtr image_before_;
  KeypointsConstPtr keypoints_before_;
  sensor_msgs::ImageConstPtr beside_before_;  ///< the last depth image, or right one with ~input stereo
  std::shared_ptr<const CameraModel> camera_before_;

  std::mutex features_mutex_;  ///< guards what follows
  MaskSource mask_source_;
  StereoDepth stereo_depth_;
};

}  // namespace gms_ransac
