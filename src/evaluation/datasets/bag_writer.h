// Writes images, depth and ground truth as a bag with the layout of the official TUM bags or of kitti2bag.
#pragma once

#include <memory>
#include <string>

#include <rosbag/bag.h>
#include <sensor_msgs/Imu.h>
#include <std_msgs/Header.h>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "datasets/dataset.h"
#include "gms_ransac/camera.h"

namespace gms_ransac {

enum class BagLayout {
  /// /camera/rgb/image_color + camera_info in /openni_rgb_optical_frame, /camera/depth/image (32FC1 metres) +
  /// camera_info, /tf: /world -> /kinect -> /openni_camera -> /openni_rgb_frame -> /openni_rgb_optical_frame. Frame
  /// names carry the leading slash of the official bags.
  kTum,
  /// kitti2bag's odom_gray: /kitti/camera_gray_left/image_rect + camera_info (P alone, K and R zero, D empty, no
  /// model) in camera_gray_left, /tf: world -> camera_left. Colour images go to /kitti/camera_color_left, those of the
  /// right camera to /kitti/camera_gray_right or /kitti/camera_color_right.
  kKitti
};

class BagWriter {
 public:
  /// Writes `path`.active, as rosbag record does. Throws std::runtime_error with one sentence when it cannot be
  /// written. `intrinsics` go into every camera_info.
  BagWriter(const std::string& path, BagLayout layout, const CameraIntrinsics& intrinsics);
  /// Removes the file unless it was closed.
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// CV_8UC1 or CV_8UC3 (BGR) with its camera_info. Stamps are in seconds, > 0. Throws as the constructor, as all
  /// below.
  void writeImage(double stamp, const cv::Mat& image);
  /// The image of the right camera at the same moment, with its camera_info; layout kKitti alone.
  void writeRightImage(double stamp, const cv::Mat& image, const RightCamera& camera);
  /// CV_32FC1, metres along the optical axis, registered to the colour image, 0 where unknown (NaN in the message).
  void writeDepth(double stamp, const cv::Mat& depth);
  /// X_world = camera_pose * X_camera, optical frame of the colour camera.
  void writeGroundTruth(double stamp, const Eigen::Isometry3d& camera_pose);
  /// A sample of an IMU, to /imu.
  void writeImu(const sensor_msgs::Imu& sample);
  /// The place of another sensor on the colour camera, X_camera = place * X_sensor, to /tf; layout kTum alone.
  void writeSensorPlace(double stamp, const std::string& frame, const Eigen::Isometry3d& place);
  /// Finishes the file and gives it its name; an earlier file of that name is replaced.
  void close();

 private:
  /// `baseline`: metres from the left camera, 0 of the left one.
  void writeCameraInfo(const std::string& topic, double stamp, const std::string& frame, cv::Size size,
                       const CameraIntrinsics& intrinsics, double baseline = 0);
  void writeKittiImage(const std::string& side, double stamp, const cv::Mat& image, const CameraIntrinsics& intrinsics,
                       double baseline);

  template <typename Message>
  void write(const std::string& topic, const std_msgs::Header& header, const Message& message);

  std::unique_ptr<rosbag::Bag> bag_;
  const std::string path_, active_;
  BagLayout layout_;
  CameraIntrinsics intrinsics_;
};

}  // namespace gms_ransac
