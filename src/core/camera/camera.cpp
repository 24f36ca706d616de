#include "gms_ransac/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <opencv2/core.hpp>

#include "camera/distortion.h"

namespace gms_ransac {

namespace {

// Table spacing in pixels, with one row and column more on each side than the image needs. At this spacing cubic
// interpolation meets the tolerance everywhere for the calibrations of the usual benchmark sets (camera_test.cpp).
constexpr int kTableStep = 8;
// Largest error of the round trip, pixels: a hundredth of a keypoint's.
constexpr double kTolerance = 0.005;
// Round-trip error, pixels, above which the model has no inverse.
constexpr double kThereAndBack = 0.1;  // pixels
// Pixels that are looked at for one without inverse; of larger images every second, third, ... up to every eighth.
constexpr double kMostCounted = 320 * 240;

// Pixels, as for ~camera in cfg/parameters.py. Single precision can hold these.
constexpr double kSmallestFocalLength = 1e-3, kLargest = 1e6;

/// Weights of the four samples around a fraction in [0, 1): Catmull-Rom.
void cubicWeights(float f, float (&weights)[4]) {
  weights[0] = 0.5f * f * (-1 + f * (2 - f));
  weights[1] = 1 + 0.5f * f * f * (-5 + 3 * f);
  weights[2] = 0.5f * f * (1 + f * (4 - 3 * f));
  weights[3] = 0.5f * f * f * (f - 1);
}

bool hasDistortion(const CameraIntrinsics& intrinsics) {
  // Without coefficients a fisheye lens is none; with zeros it is one whose image grows evenly with the angle.
  if (intrinsics.distortion_model == "equidistant") return !intrinsics.distortion.empty();
  return std::any_of(intrinsics.distortion.begin(), intrinsics.distortion.end(), [](double d) { return d != 0; });
}

/// Beyond these bounds rays near the axis have no image, or those of two directions the same.
void checkSpheres(const CameraIntrinsics& intrinsics) {
  if (!hasSpheres(intrinsics.distortion_model)) return;
  const bool two = intrinsics.distortion_model == "double_sphere";
  if (!(intrinsics.distortion[0] > -1)) throw std::invalid_argument("intrinsics: xi must be above -1");
  if (two && !(intrinsics.distortion[1] >= 0 && intrinsics.distortion[1] <= 1)) {
    throw std::invalid_argument("intrinsics: alpha must be between 0 and 1");
  }
}

CameraIntrinsics pinholeOf(const CameraIntrinsics& intrinsics) {
  intrinsics.validate();
  const double magnification = magnificationOf(intrinsics);
  return {intrinsics.fx / magnification, intrinsics.fy / magnification, intrinsics.cx, intrinsics.cy, "", {}};
}

}  // namespace

void CameraIntrinsics::validate() const {
  for (double value : {fx, fy, cx, cy}) {
    if (!std::isfinite(value)) throw std::invalid_argument("intrinsics: fx, fy, cx and cy must be finite numbers");
  }
  if (fx < 0 || fy < 0) throw std::invalid_argument("intrinsics: fx and fy must not be negative");
  const auto isFocalLength = [](double f) { return f == 0 || (f >= kSmallestFocalLength && f <= kLargest); };
  if (!isFocalLength(fx) || !isFocalLength(fy) || std::abs(cx) > kLargest || std::abs(cy) > kLargest) {
    throw std::invalid_argument("intrinsics: fx and fy must be between 0.001 and 1e6 pixels, cx and cy within 1e6");
  }
  for (double value : distortion) {
    if (!std::isfinite(value)) throw std::invalid_argument("intrinsics: distortion coefficients must be finite");
  }
  struct Model {
    const char* name;
    std::vector<size_t> counts;
    const char* accepted;
  };
  const std::string name = distortion_model.empty() ? "plumb_bob" : distortion_model;
  for (const Model& model :
       {Model{"plumb_bob", {0, 4, 5}, "4 or 5"}, Model{"rational_polynomial", {0, 8, 12, 14}, "8, 12 or 14"},
        Model{"equidistant", {0, 4}, "4"}, Model{"omnidirectional", {5}, "5 (xi, k1, k2, p1, p2)"},
        Model{"double_sphere", {2}, "2 (xi, alpha)"}}) {
    if (name != model.name) continue;
    // Some drivers fill D up with zeros.
    size_t n = distortion.size();
    while (n > model.counts.back() && distortion[n - 1] == 0) --n;
    if (std::count(model.counts.begin(), model.counts.end(), n) > 0) {
      checkSpheres(*this);
      return;
    }
    throw std::invalid_argument("intrinsics: " + name + " takes " + model.accepted + " distortion coefficients, not " +
                                std::to_string(distortion.size()));
  }
  throw std::invalid_argument("intrinsics: unknown distortion model '" + distortion_model +
                              "'; use plumb_bob, rational_polynomial, equidistant, omnidirectional or double_sphere");
}

Camera::Camera(const CameraIntrinsics& intrinsics, cv::Size image_size)
    : intrinsics_(intrinsics), pinhole_(pinholeOf(intrinsics)), image_size_(image_size) {
  if (!calibrated() || !hasDistortion(intrinsics_)) return;
  distortion_ = std::make_shared<Distortion>(intrinsics_);
  buildTable();
  may_lack_inverse_ = cv::countNonZero(interpolates_) < static_cast<int>(interpolates_.total());
  if (may_lack_inverse_) pixels_without_inverse_ = countPixelsWithoutInverse();
}

void Camera::buildTable() {
  offset_.create(image_size_.height / kTableStep + 4, image_size_.width / kTableStep + 4);
  for (int r = 0; r < offset_.rows; ++r) {
    for (int c = 0; c < offset_.cols; ++c) {
      const cv::Point2d pixel((c - 1) * kTableStep, (r - 1) * kTableStep), offset = solve(pixel) - pixel;
      offset_(r, c) = cv::Vec2f(static_cast<float>(offset.x), static_cast<float>(offset.y));
    }
  }
  interpolates_.create(offset_.rows - 3, offset_.cols - 3);
  for (int r = 0; r < interpolates_.rows; ++r) {
    for (int c = 0; c < interpolates_.cols; ++c) interpolates_(r, c) = roundTripHolds(r, c);
  }
}

bool Camera::roundTripHolds(int r, int c) const {
  for (const float down : {1 / 6.f, 0.5f, 5 / 6.f}) {
    for (const float across : {1 / 6.f, 0.5f, 5 / 6.f}) {
      const cv::Point2f pixel(kTableStep * (static_cast<float>(c) + across),
                              kTableStep * (static_cast<float>(r) + down));
      const cv::Point2d error = distortByModel(interpolate(r, c, pixel)) - cv::Point2d(pixel);
      if (!(std::hypot(error.x, error.y) < kTolerance)) return false;
    }
  }
  return true;
}

int Camera::countPixelsWithoutInverse() const {
  // Each takes microseconds if the calibration describes no lens, and a camera that zooms repeats them with each image.
  const double pixels = static_cast<double>(image_size_.width) * image_size_.height;
  const int step = std::clamp(static_cast<int>(std::ceil(std::sqrt(pixels / kMostCounted))), 1, kTableStep);
  int64_t count = 0;
  for (int y = step / 2; y < image_size_.height; y += step) {
    for (int x = step / 2; x < image_size_.width; x += step) {
      if (interpolates_(y / kTableStep, x / kTableStep)) continue;
      count += std::isnan(solve(cv::Point2d(x, y)).x);
    }
  }
  return static_cast<int>(std::min<int64_t>(count * step * step, image_size_.area()));
}

cv::Point2d Camera::solve(const cv::Point2d& pixel) const {
  const CameraIntrinsics& k = pinhole_;
  Eigen::Vector2d ideal;
  if (!distortion_->undistort({(pixel.x - k.cx) / k.fx, (pixel.y - k.cy) / k.fy}, ideal)) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {kNone, kNone};
  }
  return {k.fx * ideal.x() + k.cx, k.fy * ideal.y() + k.cy};
}

cv::Point2d Camera::distortByModel(const cv::Point2d& ideal) const {
  const CameraIntrinsics& k = pinhole_;
  const Eigen::Vector2d distorted = distortion_->distort({(ideal.x - k.cx) / k.fx, (ideal.y - k.cy) / k.fy});
  return {k.fx * distorted.x() + k.cx, k.fy * distorted.y() + k.cy};
}

Eigen::Matrix3d Camera::K() const {
  Eigen::Matrix3d K;
  K << pinhole_.fx, 0, pinhole_.cx, 0, pinhole_.fy, pinhole_.cy, 0, 0, 1;
  return K;
}

cv::Point2f Camera::undistort(const cv::Point2f& pixel) const {
  if (!distortion_) return pixel;
  const float x = pixel.x / kTableStep, y = pixel.y / kTableStep;
  const bool inside = x >= 0 && y >= 0 && x < static_cast<float>(interpolates_.cols) &&
                      y < static_cast<float>(interpolates_.rows);  // not of NaN
  if (!inside || !interpolates_(static_cast<int>(y), static_cast<int>(x))) return solve(pixel);
  return interpolate(static_cast<int>(y), static_cast<int>(x), pixel);
}

cv::Point2f Camera::distort(const cv::Point2f& ideal) const {
  if (!distortion_) return ideal;
  const cv::Point2f pixel = distortByModel(ideal), back = undistort(pixel) - ideal;
  if (std::hypot(back.x, back.y) < kThereAndBack) return pixel;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  return {kNone, kNone};
}

cv::Point2f Camera::interpolate(int r, int c, const cv::Point2f& pixel) const {
  float across[4], down[4];
  cubicWeights(pixel.x / kTableStep - static_cast<float>(c), across);
  cubicWeights(pixel.y / kTableStep - static_cast<float>(r), down);
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
