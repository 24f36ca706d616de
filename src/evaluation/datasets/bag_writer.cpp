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

std::string encodingOf(const cv::Mat& image) {
  return image.channels() == 3 ? sensor_msgs::image_encodings::BGR8 : sensor_msgs::image_encodings::MONO8;
}

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

/// Runs what writes to the bag; throws with its path if that fails.
template <typename Call>
void writing(const std::string& path, const Call& call) {
  try {
    call();
  } catch (const rosbag::BagIOException&) {
    throw std::runtime_error(path + ": writing failed; is the disk full?");
  }
}

}  // namespace

BagWriter::BagWriter(const std::string& path, BagLayout layout, const CameraIntrinsics& intrinsics)
    : bag_(std::make_unique<rosbag::Bag>()),
      path_(path),
      active_(path + ".active"),
      layout_(layout),
      intrinsics_(intrinsics) {
  try {
    bag_->open(active_, rosbag::bagmode::Write);
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": cannot be written (" + error.what() + ")");
  }
}

BagWriter::~BagWriter() {
  std::error_code none;                            // after close() there is no such file
  std::filesystem::resize_file(active_, 0, none);  // on a full disk this makes the room that closing takes
  std::filesystem::remove(active_, none);
  try {
    bag_->close();
  } catch (const rosbag::BagException&) {
    // A bag that cannot be closed ends the program when it closes itself, so it is never destroyed. Something points to
    // it, or it would be a leak.
    [[maybe_unused]] static rosbag::Bag* volatile unclosed = nullptr;
    unclosed = bag_.release();
  }
}

template <typename Message>
void BagWriter::write(const std::string& topic, const std_msgs::Header& header, const Message& message) {
  writing(path_, [&] { bag_->write(topic, header.stamp, message); });
}

void BagWriter::writeCameraInfo(const std::string& topic, double stamp, const std::string& frame, cv::Size size,
                                const CameraIntrinsics& intrinsics, double baseline) {
  sensor_msgs::CameraInfo info;
  info.header = header(stamp, frame);
  info.width = size.width;
  info.height = size.height;
  const CameraIntrinsics& k = intrinsics;
  info.P = {k.fx, 0, k.cx, -k.fx * baseline, 0, k.fy, k.cy, 0, 0, 0, 1, 0};
  if (layout_ == BagLayout::kTum) {
    info.K = {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1};
    info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    info.distortion_model = k.distortion_model.empty() ? "plumb_bob" : k.distortion_model;
    info.D = k.distortion;
    if (info.distortion_model == "plumb_bob" && !info.D.empty()) info.D.resize(5);
  }
  write(topic, info.header, info);
}

void BagWriter::writeImage(double stamp, const cv::Mat& image) {
  if (layout_ == BagLayout::kKitti) return writeKittiImage("left", stamp, image, intrinsics_, 0);
  const cv_bridge::CvImage message(header(stamp, kOpenNiFrame), encodingOf(image), image);
  write("/camera/rgb/image_color", message.header, message.toImageMsg());
  writeCameraInfo("/camera/rgb/camera_info", stamp, kOpenNiFrame, image.size(), intrinsics_);
}

void BagWriter::writeRightImage(double stamp, const cv::Mat& image, const RightCamera& camera) {
  writeKittiImage("right", stamp, image, camera.intrinsics, camera.baseline);
}

void BagWriter::writeKittiImage(const std::string& side, double stamp, const cv::Mat& image,
                                const CameraIntrinsics& intrinsics, double baseline) {
  const std::string frame = (image.channels() == 3 ? "camera_color_" : "camera_gray_") + side;
  const cv_bridge::CvImage message(header(stamp, frame), encodingOf(image), image);
  write("/kitti/" + frame + "/image_rect", message.header, message.toImageMsg());
  writeCameraInfo("/kitti/" + frame + "/camera_info", stamp, frame, image.size(), intrinsics, baseline);
}

void BagWriter::writeDepth(double stamp, const cv::Mat& depth) {
  cv::Mat metres = depth.clone();
  metres.setTo(std::numeric_limits<float>::quiet_NaN(), depth <= 0);
  const cv_bridge::CvImage message(header(stamp, kOpenNiFrame), sensor_msgs::image_encodings::TYPE_32FC1, metres);
  write("/camera/depth/image", message.header, message.toImageMsg());
  writeCameraInfo("/camera/depth/camera_info", stamp, kOpenNiFrame, depth.size(), intrinsics_);
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
  write("/tf", message.transforms.front().header, message);
}

void BagWriter::writeImu(const sensor_msgs::Imu& sample) { write("/imu", sample.header, sample); }

void BagWriter::writeSensorPlace(double stamp, const std::string& frame, const Eigen::Isometry3d& place) {
  tf2_msgs::TFMessage message;
  message.transforms = {transform(stamp, kOpenNiFrame, frame, place)};
  write("/tf", message.transforms.front().header, message);
}

void BagWriter::close() {
  writing(path_, [&] { bag_->close(); });
  std::filesystem::rename(active_, path_);
}

}  // namespace gms_ransac
