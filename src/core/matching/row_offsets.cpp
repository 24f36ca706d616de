#include "matching/row_offsets.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

constexpr float kOffsetReach = 3;                       ///< pixels that a patch may be away from the offset expected
constexpr size_t kFirstAsked = 240, kPointsAsked = 60;  ///< points of the first image, and of each other
constexpr double kOffsetMemory = 0.98;                  ///< weight of what is known, from image to image
// Standard deviation of the offset of a point, pixels; one that is so far from the offset expected has a quarter of its
// weight. For the first image no offset is expected.
constexpr double kOffsetNoise = 0.3, kFirstSpread = 1;
constexpr double kOffsetPrior =
    1;  ///< of each coefficient, pixels; with less, KITTI's corners stay off for many images
// Offsets that a calibration may leave, pixels: of the whole image, and in its corners. KITTI's rectified images have
// 0.2, and 2 in the corners. Larger ones are none of a calibration, and are not corrected.
constexpr double kMostOffset = 1, kMostAtRim = 3;

}  // namespace

Eigen::Vector4d RowOffsets::factors(const cv::Point2f& pixel) const {
  const double x = 2 * pixel.x / size_.width - 1, y = 2 * pixel.y / size_.height - 1;
  return {1, x, y, x * y};
}

double RowOffsets::disparityError(const cv::Point2f& pixel, const CameraIntrinsics& k) const {
  const double horizon = 2 * k.cy / size_.height - 1, below = pixel.y - k.cy;
  const double roll = 2. / size_.width * (coefficients_[1] + coefficients_[3] * horizon);
  const double bend = 4. / size_.area() * coefficients_[3] * k.fx / k.fy;
  return (roll + bend * below) * below;
}

void RowOffsets::measure(const cv::Mat& left, const cv::Mat& right, const std::vector<cv::Point2f>& points,
                         RowSearch& search) {
  if (size_ != left.size()) *this = RowOffsets();
  size_ = left.size();
  const bool first = information_.isZero();
  const size_t stride = 1 + points.size() / (first ? kFirstAsked : kPointsAsked);
  information_ *= kOffsetMemory;
  moments_ *= kOffsetMemory;
  for (size_t i = 0; i < points.size(); i += stride) {
    const cv::Point pixel(static_cast<int>(std::lround(points[i].x)), static_cast<int>(std::lround(points[i].y)));
    const double expected = at(pixel);
    const auto disparity = search.disparity(pixel, expected);
    Patch patch;
    const Eigen::Vector2f centre(static_cast<float>(pixel.x), static_cast<float>(pixel.y));
    if (!disparity || !patch.cut(left, centre)) continue;
    PatchPlace guess;
    guess.centre = centre + Eigen::Vector2f(static_cast<float>(-*disparity), static_cast<float>(expected));
    const auto found = patch.find(right, guess, {kOffsetReach});
    if (!found) continue;
    const double below = found->centre.y() - centre.y(),
                 ratio = (below - expected) / (first ? kFirstSpread : kOffsetNoise);
    const double weight = 1 / ((1 + ratio * ratio) * (1 + ratio * ratio));
    const Eigen::Vector4d f = factors(pixel);
    information_ += weight * f * f.transpose();
    moments_ += weight * below * f;
  }
  const double prior = kOffsetNoise * kOffsetNoise / (kOffsetPrior * kOffsetPrior);
  coefficients_ = (information_ + prior * Eigen::Matrix4d::Identity()).ldlt().solve(moments_);
  if (std::abs(coefficients_[0]) > kMostOffset || coefficients_.lpNorm<1>() > kMostAtRim) coefficients_.setZero();
}

}  // namespace gms_ransac
