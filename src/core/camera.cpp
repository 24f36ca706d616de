#include "gms_ransac/camera.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {

namespace {

// Table spacing in pixels, with one row and column more on each side than the image needs. At this spacing cubic
// interpolation stays within 0.005 px of OpenCV's iteration for the calibrations in camera_test.cpp.
constexpr int kTableStep = 8;

/// Weights of the four samples around a fraction in [0, 1): Catmull-Rom.
void cubicWeights(float f, float (&weights)[4]) {
  weights[0] = 0.5f * f * (-1 + f * (2 - f));
  weights[1] = 1 + 0.5f * f * f * (-5 + 3 * f);
  weights[2] = 0.5f * f * (1 + f * (4 - 3 * f));
  weights[3] = 0.5f * f * f * (f - 1);
}

bool hasDistortion(const CameraIntrinsics& intrinsics) {
  return std::any_of(intrinsics.distortion.begin(), intrinsics.distortion.end(), [](double d) { return d != 0; });
}

}  // namespace

void CameraIntrinsics::validate() const {
  for (double value : {fx, fy, cx, cy}) {
    if (!std::isfinite(value)) throw std::invalid_argument("intrinsics: fx, fy, cx and cy must be finite numbers");
  }
  if (fx < 0 || fy < 0) throw std::invalid_argument("intrinsics: fx and fy must not be negative");
  for (double value : distortion) {
    if (!std::isfinite(value)) throw std::invalid_argument("intrinsics: distortion coefficients must be finite");
  }
  const size_t n = distortion.size();
  if (distortion_model.empty() || distortion_model == "plumb_bob") {
    if (n != 0 && n != 4 && n != 5) {
      throw std::invalid_argument("intrinsics: plumb_bob takes 4 or 5 distortion coefficients, not " +
                                  std::to_string(n));
    }
  } else if (distortion_model == "rational_polynomial") {
    if (n != 0 && n != 8 && n != 12 && n != 14) {
      throw std::invalid_argument("intrinsics: rational_polynomial takes 8, 12 or 14 distortion coefficients, not " +
                                  std::to_string(n));
    }
  } else if (distortion_model == "equidistant") {
    if (n != 0 && n != 4) {
      throw std::invalid_argument("intrinsics: equidistant takes 4 distortion coefficients, not " + std::to_string(n));
    }
  } else {
    throw std::invalid_argument("intrinsics: unknown distortion model '" + distortion_model +
                                "'; use plumb_bob, rational_polynomial or equidistant");
  }
}

Camera::Camera(const CameraIntrinsics& intrinsics, cv::Size image_size)
    : intrinsics_(intrinsics), image_size_(image_size) {
  intrinsics_.validate();
  if (!calibrated() || !hasDistortion(intrinsics_)) return;

  const int columns = image_size.width / kTableStep + 4, rows = image_size.height / kTableStep + 4;
  std::vector<cv::Point2d> pixels, ideal;
  pixels.reserve(static_cast<size_t>(columns) * rows);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) pixels.emplace_back((c - 1) * kTableStep, (r - 1) * kTableStep);
  }
  const cv::Matx33d K(intrinsics_.fx, 0, intrinsics_.cx, 0, intrinsics_.fy, intrinsics_.cy, 0, 0, 1);
  if (intrinsics_.distortion_model == "equidistant") {
    cv::fisheye::undistortPoints(pixels, ideal, K, intrinsics_.distortion, cv::noArray(), K);
  } else {
    // The default of five iterations leaves several pixels of error in the corners of strongly distorted images.
    const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10);
    cv::undistortPoints(pixels, ideal, K, intrinsics_.distortion, cv::noArray(), K, until);
  }
  offset_.create(rows, columns);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const cv::Point2d offset =
          ideal[static_cast<size_t>(r) * columns + c] - pixels[static_cast<size_t>(r) * columns + c];
      offset_(r, c) = cv::Vec2f(static_cast<float>(offset.x), static_cast<float>(offset.y));
    }
  }
}

Eigen::Matrix3d Camera::K() const {
  Eigen::Matrix3d K;
  K << intrinsics_.fx, 0, intrinsics_.cx, 0, intrinsics_.fy, intrinsics_.cy, 0, 0, 1;
  return K;
}

cv::Point2f Camera::undistort(const cv::Point2f& pixel) const {
  if (offset_.empty()) return pixel;
  const float x = pixel.x / kTableStep, y = pixel.y / kTableStep;
  const int c = std::clamp(static_cast<int>(x), 0, offset_.cols - 4);
  const int r = std::clamp(static_cast<int>(y), 0, offset_.rows - 4);
  float across[4], down[4];
  cubicWeights(x - c, across);
  cubicWeights(y - r, down);
  cv::Point2f ideal = pixel;
  for (int i = 0; i < 4; ++i) {
    const cv::Vec2f* row = offset_[r + i] + c;
    const cv::Vec2f offset = row[0] * across[0] + row[1] * across[1] + row[2] * across[2] + row[3] * across[3];
    ideal.x += down[i] * offset[0];
    ideal.y += down[i] * offset[1];
  }
  return ideal;
}

bool Camera::operator==(const Camera& other) const {
  const CameraIntrinsics &a = intrinsics_, &b = other.intrinsics_;
  return a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy && a.distortion_model == b.distortion_model &&
         a.distortion == b.distortion && image_size_ == other.image_size_;
}

}  // namespace gms_ransac
