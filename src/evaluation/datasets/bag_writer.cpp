#include "datasets/bag_writer.h"

#include <filesystem>
#include <limits>
#include <stdexcept>

#include <cv_bridge/cv_bridge.h>
#include <rosbag/exceptions.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_msgs/TFMessage.h>

namespace gms_ransac {

namespace {

const char kOpenNiFrame[] = "/openni_rgb_optical_frame";

/// X_openni_camera = T X_rgb_optical of the OpenNI driver's default: the colour camera 45 mm to the right of the
/// body, and from body axes (x forward, z up) to optical ones.
Eigen::Isometry3d openNiRgbFrame() { return Eigen::Isometry3d(Eigen::Translation3d(0, -0.045, 0)); }
Eigen::Isometry3d opticalFrame() { return Eigen::Isometry3d(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5)); }

std_msgs::Header header(double stamp, const std::string& frame) {
  std_msgs::Header result;
  result.stamp = ros::Time(stamp);
  result.frame_id = frame;
  return result;
}

geometry_msgs::TransformStamped transform(double stamp, const std::string& parent, const std::string& child,
                                          const Eigen::Isometry3d& pose) {
  geometry_msgs::TransformStamped result = tf2::eigenToTransform(pose);
  result.header = header(stamp, parent);
  result.child_frame_id = child;
  return result;
}

}  // namespace

BagWriter::BagWriter(const std::string& path, BagLayout layout, const CameraIntrinsics& intrinsics)
    : path_(path), active_(path + ".active"), layout_(layout), intrinsics_(intrinsics) {
  try {
    bag_.open(active_, rosbag::bagmode::Write);
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": cannot be written (" + error.what() + ")");
  }
}

BagWriter::~BagWriter() {
  std::error_code none;  // after close() there is no such file
  std::filesystem::remove(active_, none);
}

void BagWriter::writeCameraInfo(const std::string& topic, double stamp, const std::string& frame, cv::Size size) {
  sensor_msgs::CameraInfo info;
  info.header = header(stamp, frame);
  info.width = size.width;
  info.height = size.height;
  const CameraIntrinsics& k = intrinsics_;
  info.P = {k.fx, 0, k.cx, 0, 0, k.fy, k.cy, 0, 0, 0, 1, 0};
  if (layout_ == BagLayout::kTum) {
    info.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
    info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    info.distortion_model = k.distortion_model.empty() ? "plumb_bob" : k.distortion_model;
    info.D = k.distortion;
    if (info.distortion_model == "plumb_bob") info.D.resize(5);
  }
  bag_.write(topic, info.header.stamp, info);
}

void BagWriter::writeImage(double stamp, const cv::Mat& image) {
  const bool colour = image.channels() == 3;
  std::string prefix = "/camera/rgb/", name = "image_color", frame = kOpenNiFrame;
  if (layout_ == BagLayout::kKitti) {
    frame = colour ? "camera_color_left" : "camera_gray_left";
    prefix = "/kitti/" + frame + "/";
    name = "image_rect";
  }
  const std::string encoding = colour ? sensor_msgs::image_encodings::BGR8 : sensor_msgs::image_encodings::MONO8;
  const cv_bridge::CvImage message(header(stamp, frame), encoding, image);
  bag_.write(prefix + name, message.header.stamp, message.toImageMsg());
  writeCameraInfo(prefix + "camera_info", stamp, frame, image.size());
}

void BagWriter::writeDepth(double stamp, const cv::Mat& depth) {
  cv::Mat metres = depth.clone();
  metres.setTo(std::numeric_limits<float>::quiet_NaN(), depth <= 0);
  const cv_bridge::CvImage message(header(stamp, kOpenNiFrame), sensor_msgs::image_encodings::TYPE_32FC1, metres);
  bag_.write("/camera/depth/image", message.header.stamp, message.toImageMsg());
  writeCameraInfo("/camera/depth/camera_info", stamp, kOpenNiFrame, depth.size());
}

void BagWriter::writeGroundTruth(double stamp, const Eigen::Isometry3d& camera_pose) {
  tf2_msgs::TFMessage message;
  if (layout_ == BagLayout::kKitti) {
    message.transforms.push_back(transform(stamp, "world", "camera_left", camera_pose));
  } else {
    const Eigen::Isometry3d kinect_pose = camera_pose * (openNiRgbFrame() * opticalFrame()).inverse();
    message.transforms = {transform(stamp, "/world", "/kinect", kinect_pose),
                          transform(stamp, "/kinect", "/openni_camera", Eigen::Isometry3d::Identity()),
                          transform(stamp, "/openni_camera", "/openni_rgb_frame", openNiRgbFrame()),
                          transform(stamp, "/openni_rgb_frame", kOpenNiFrame, opticalFrame())};
  }
  bag_.write("/tf", ros::Time(stamp), message);
}

void BagWriter::close() {
  bag_.close();
  std::filesystem::rename(active_, path_);
}

}  // namespace gms_ransac
