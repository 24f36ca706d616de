// A calibrated camera: pixels of the received image to normalised image coordinates and undistorted pixels.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

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

class Distortion;

/// Undoes the distortion through a table built once, so that a frame's keypoints cost microseconds; distorting again
/// what comes out gives the pixel back within 0.005 px, as the table is checked when it is built. Where it fails that,
/// the model is solved point by point.
class Camera {
 public:
  Camera() = default;  ///< not calibrated: points pass through unchanged
  Camera(const CameraIntrinsics& intrinsics, cv::Size image_size);

  bool calibrated() const { return intrinsics_.calibrated(); }
  const CameraIntrinsics& intrinsics() const { return intrinsics_; }
  cv::Size imageSize() const { return image_size_; }
  Eigen::Matrix3d K() const;
  double meanFocalLength() const { return 0.5 * (intrinsics_.fx + intrinsics_.fy); }  ///< pixels
  bool distorts() const { return distortion_ != nullptr; }  ///< if not, `undistort` returns the pixel
  /// Pixel of the received image -> pixel of the ideal pinhole camera with the same K; NaN where the model of the
  /// distortion has no inverse (beyond the radius up to which it is monotone, or a right angle off the axis).
  cv::Point2f undistort(const cv::Point2f& pixel) const;
  /// Pixel of that pinhole camera -> pixel of the received image; NaN where `undistort` does not lead back.
  cv::Point2f distort(const cv::Point2f& ideal) const;
  /// Pixels of the image of which that is so: a calibration that does not hold for the whole image.
  int pixelsWithoutInverse() const { return pixels_without_inverse_; }
  bool operator==(const Camera& other) const;
  bool operator!=(const Camera& other) const { return !(*this == other); }

 private:
  void buildTable();
  /// The verdict on one cell, whose four by four samples begin at (r, c).
  bool roundTripHolds(int r, int c) const;
  int countPixelsWithoutInverse() const;
  cv::Point2d solve(const cv::Point2d& pixel) const;
  cv::Point2d distortByModel(const cv::Point2d& ideal) const;
  cv::Point2f interpolate(int r, int c, const cv::Point2f& pixel) const;

  CameraIntrinsics intrinsics_;
  cv::Size image_size_;
  std::shared_ptr<const Distortion> distortion_;  ///< null: none
  cv::Mat_<cv::Vec2f> offset_;                    ///< undistorted minus received pixel, sampled every kTableStep pixels
  cv::Mat_<uint8_t> interpolates_;                ///< of each cell of that table: it may be interpolated in
  int pixels_without_inverse_ = 0;
};

}  // namespace gms_ransac
