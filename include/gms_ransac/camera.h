// A calibrated camera: pixels of the received image to normalised image coordinates and undistorted pixels.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace gms_ransac {

/// Intrinsics as ROS and OpenCV define them. An all-zero K: not calibrated.
struct CameraIntrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  /// "" or "plumb_bob", "rational_polynomial", "equidistant", "omnidirectional" (Mei), "double_sphere"
  std::string distortion_model;
  /// In the order of D of sensor_msgs/CameraInfo; empty: none. Zeros behind those of the model are ignored.
  /// omnidirectional: xi, k1, k2, p1, p2; double_sphere: xi, alpha; the focal lengths are then those of the plane
  /// behind the spheres.
  std::vector<double> distortion;

  bool calibrated() const { return fx > 0 && fy > 0; }
  /// Throws std::invalid_argument naming the field: non-finite or negative focal length, unknown model, wrong count.
  void validate() const;
};

class Distortion;

/// Undoes the distortion through a table built once. Where distorting again misses the pixel by more than 0.005 px the
/// model is solved point by point.
class Camera {
 public:
  Camera() = default;  ///< not calibrated: points pass through unchanged
  Camera(const CameraIntrinsics& intrinsics, cv::Size image_size);

  bool calibrated() const { return intrinsics_.calibrated(); }
  /// Intrinsics of the received image, as they were given.
  const CameraIntrinsics& intrinsics() const { return intrinsics_; }
  /// The ideal pinhole camera that `undistort` leads to: with spheres its focal lengths are smaller by 1 + xi.
  const CameraIntrinsics& pinhole() const { return pinhole_; }
  cv::Size imageSize() const { return image_size_; }
  Eigen::Matrix3d K() const;                                                    ///< of that pinhole camera
  double meanFocalLength() const { return 0.5 * (pinhole_.fx + pinhole_.fy); }  ///< of that pinhole camera, pixels
  bool distorts() const { return distortion_ != nullptr; }  ///< if not, `undistort` returns the pixel
  /// Received pixel -> pixel of the pinhole camera; NaN where the model has no inverse.
  cv::Point2f undistort(const cv::Point2f& pixel) const;
  /// Pixel of that pinhole camera -> pixel of the received image; NaN where `undistort` does not lead back.
  cv::Point2f distort(const cv::Point2f& ideal) const;
  /// About how many pixels `undistort` has no answer for: the calibration does not hold for the whole image.
  int pixelsWithoutInverse() const { return pixels_without_inverse_; }
  /// False: `undistort` has an answer for every pixel of the image.
  bool mayLackInverse() const { return may_lack_inverse_; }
  bool operator==(const Camera& other) const;
  bool operator!=(const Camera& other) const { return !(*this == other); }

 private:
  void buildTable();
  /// True if the cell of four by four samples from (r, c) may be interpolated in.
  bool roundTripHolds(int r, int c) const;
  int countPixelsWithoutInverse() const;
  cv::Point2d solve(const cv::Point2d& pixel) const;
  cv::Point2d distortByModel(const cv::Point2d& ideal) const;
  cv::Point2f interpolate(int r, int c, const cv::Point2f& pixel) const;

  CameraIntrinsics intrinsics_, pinhole_;
  cv::Size image_size_;
  std::shared_ptr<const Distortion> distortion_;  ///< null: none
  cv::Mat_<cv::Vec2f> offset_;                    ///< undistorted minus received pixel, sampled every kTableStep pixels
  cv::Mat_<uint8_t> interpolates_;                ///< of each cell of that table: it may be interpolated in
  int pixels_without_inverse_ = 0;
  bool may_lack_inverse_ = false;  ///< some cells may not be interpolated in
};

/// (x, y) of the ray (x, y, 1) of a received pixel of a calibrated camera; NaN where `undistort` has none.
inline Eigen::Vector2d rayOf(const Camera& camera, const cv::Point2f& pixel) {
  const CameraIntrinsics& k = camera.pinhole();
  const cv::Point2f ideal = camera.undistort(pixel);
  return {(ideal.x - k.cx) / k.fx, (ideal.y - k.cy) / k.fy};
}

inline cv::Point2f pixelOf(const Camera& camera, const Eigen::Vector2d& ray) {
  const CameraIntrinsics& k = camera.pinhole();
  return camera.distort({static_cast<float>(k.fx * ray.x() + k.cx), static_cast<float>(k.fy * ray.y() + k.cy)});
}

}  // namespace gms_ransac
