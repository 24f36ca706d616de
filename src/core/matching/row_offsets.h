// By how many rows the right of two rectified images shows what the left one shows, as their calibration leaves it.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "matching/patch.h"
#include "matching/row_search.h"

namespace gms_ransac {

/// An offset that grows with x, y and x y, as that of cameras which are tilted, rolled or rotated against each other.
/// Learned from a few points of each image, which patches locate in both; old images count less.
class RowOffsets {
 public:
  /// Rows by which the right image shows this pixel lower.
  double at(const cv::Point2f& pixel) const { return coefficients_.dot(factors(pixel)); }
  /// Pixels by which the same causes make a disparity too large. A camera that is rolled adds an error in proportion to
  /// y, and an image that was undistorted around a wrong centre one in proportion to y^2.
  double disparityError(const cv::Point2f& pixel, const CameraIntrinsics& k) const;
  /// Learns from some of the points. `search`: of these images.
  void measure(const cv::Mat& left, const cv::Mat& right, const std::vector<cv::Point2f>& points, RowSearch& search);

 private:
  /// 1, x, y, x y; x and y from -1 to 1 across the image.
  Eigen::Vector4d factors(const cv::Point2f& pixel) const;

  cv::Size size_ = {2, 2};
  Eigen::Matrix4d information_ = Eigen::Matrix4d::Zero();
  Eigen::Vector4d moments_ = Eigen::Vector4d::Zero(), coefficients_ = Eigen::Vector4d::Zero();
};

}  // namespace gms_ransac
