// Image or Keypoints message -> grey image, features, depth: the part of the work that needs no other image.
#pragma once

#include <mutex>
#include <string>

#include "input/camera_model.h"
#include "input/image_conversion.h"
#include "input/mask_source.h"
#include "input/stamp_watch.h"
#include "input/stereo_depth.h"
#include "parameters.h"
#include "stream/prepared_frame.h"

namespace gms_ransac {

/// `receive` on one thread, in the order in which images come; `findFeatures` on any.
class FramePreparation {
 public:
  /// Throws std::invalid_argument with a sentence when ~mask_file cannot be read. The topics appear in messages; those
  /// of the right camera with ~input stereo.
  FramePreparation(const Parameters& parameters, const std::string& image_topic, const std::string& info_topic,
                   const std::string& right_topic, const std::string& right_info_topic);

  /// Conversion, stamp rules, camera: all but the features. `frame` may have served another image; its pipeline is
  /// set already. Never throws.
  void receive(const ImageWithInfo& input, PreparedFrame& frame);
  /// Finds the features of a usable image that has none yet, and what depends on them; sets a problem if that fails.
  void findFeatures(PreparedFrame& frame);

 private:
  /// Converts one image; false, with `problem` set, if it is unusable.
  bool convert(const sensor_msgs::ImageConstPtr& image, PreparedFrame& frame);
  /// Features, and depth with ~scale depth, of a Keypoints message.
  void takeKeypoints(const Keypoints& keypoints, PreparedFrame& frame);
  /// Sets the verdict, and the problem of an image that is to be dropped.
  void classifyStamp(PreparedFrame& frame);
  /// Finds the features outside the masked area, or drops given ones inside it.
  void extract(MatchFilter& filter, PreparedFrame& frame);
  /// Depth of the keypoints, from a depth image or the right camera.
  void findDepth(PreparedFrame& frame);

  const Parameters parameters_;
  ImageConverter converter_;
  CameraModelSource camera_source_;
  StampWatch stamps_;

  std::mutex features_mutex_;  ///< guards what follows
  MaskSource mask_source_;
  StereoDepth stereo_depth_;
};

}  // namespace gms_ransac
