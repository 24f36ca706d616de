// camera_info messages -> the core's camera: raw or rectified, region of interest, binning.
#pragma once

#include <memory>
#include <string>

#include <sensor_msgs/CameraInfo.h>

#include "gms_ransac/camera.h"
#include "parameters.h"
#include "throttle.h"

namespace gms_ransac {

/// A camera and how it was found.
struct CameraModel {
  Camera camera;
  std::string source;   ///< of the calibration, for sentences: "the parameters ~camera"
  std::string problem;  ///< why the camera is not calibrated, and what to do; empty when it is
  std::string doubt;    ///< why the calibration may be that of another camera, and what to do; empty: no reason
  std::string warning;  ///< how much of the image the calibration does not cover; empty when it covers all of it

  /// The received pixels are free of distortion.
  bool rectified() const { return !camera.distorts(); }
};

/// Remembers the last model: camera_info seldom changes, and a table of distortion takes milliseconds.
class CameraModelSource {
 public:
  CameraModelSource(const Parameters& parameters, const std::string& image_topic, const std::string& info_topic);

  /// The model for an image of this size; `info` may be null. Logs the four numbers when they change.
  std::shared_ptr<const CameraModel> get(const sensor_msgs::CameraInfoConstPtr& info, cv::Size image_size);

 private:
  std::shared_ptr<const CameraModel> makeAndTell(const sensor_msgs::CameraInfo* info, cv::Size image_size);
  /// Sets the camera or the problem of the model; throws std::exception with the end of a sentence.
  void make(const sensor_msgs::CameraInfo* info, cv::Size image_size, CameraModel& model) const;
  void fromInfo(const sensor_msgs::CameraInfo& info, cv::Size image_size, CameraModel& model) const;
  std::string doubtOf(const CameraModel& model, const sensor_msgs::CameraInfo* info, cv::Size image_size) const;
  /// Empty when `info` does not say a size.
  std::string sizeMismatch(const sensor_msgs::CameraInfo& info, cv::Size image_size) const;
  /// Empty unless the pixels of `info` are far from square, it is that of an uncalibrated Kinect, or K is used although
  /// it fits the image worse than P.
  std::string unlikelyValues(const sensor_msgs::CameraInfo& info, cv::Size image_size) const;
  std::string contradiction(const sensor_msgs::CameraInfo& info, cv::Size image_size) const;

  CameraIntrinsics override_;
  Rectified input_is_rectified_;
  std::string or_set_;  ///< how sentences end that advise to calibrate, where ~camera may replace camera_info
  std::string image_topic_, info_topic_;
  std::shared_ptr<const CameraModel> model_;  ///< the last one; null: nothing yet
  cv::Size size_;
  sensor_msgs::CameraInfoConstPtr info_;  ///< null: there was none. Not a copy: its coefficients may be any number
  Throttle throttle_;
};

}  // namespace gms_ransac
