// A calibrated camera: pixels of the received image to normalised image coordinates and undistorted pixels.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace gms_ransac {

/// Intrinsics as ROS and OpenCV define them. An all-zero K means "not calibrated".
struct CameraIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  std::string distortion_model;           ///< "" or "plumb_bob", "rational_polynomial", "equidistant"
  std::vector<double> distortion;         ///< in the order of sensor_msgs/CameraInfo::D; empty: none

  bool calibrated() const { return fx > 0 && fy > 0; }
  /// Throws std::invalid_argument naming the field: non-finite or negative focal length, unknown model, wrong count.
  void validate() const;
};

/// Undoes the distortion through a table built once from OpenCV's model (error below 0.005 px; see camera.cpp), so
/// that a frame's keypoints cost microseconds.
class Camera {
 public:
  Camera() = default;  ///< not calibrated: points pass through unchanged
  Camera(const CameraIntrinsics& intrinsics, cv::Size image_size);

  bool calibrated() const { return intrinsics_.calibrated(); }
  const CameraIntrinsics& intrinsics() const { return intrinsics_; }
  cv::Size imageSize() const { return image_size_; }
  Eigen::Matrix3d K() const;
  double meanFocalLength() const { return 0.5 * (intrinsics_.fx + intrinsics_.fy); }  ///< pixels
  /// Pixel of the received image -> pixel of the ideal pinhole camera with the same K.
  cv::Point2f undistort(const cv::Point2f& pixel) const;
  bool operator==(const Camera& other) const;
  bool operator!=(const Camera& other) const { return !(*this == other); }

 private:
  CameraIntrinsics intrinsics_;
  cv::Size image_size_;
  cv::Mat_<cv::Vec2f> offset_;  ///< undistorted minus received pixel, sampled every kTableStep pixels
};

}  // namespace gms_ransac
