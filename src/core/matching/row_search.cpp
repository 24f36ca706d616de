#include "matching/row_search.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <opencv2/imgproc.hpp>

#include "matching/patch_kernels.h"

namespace gms_ransac {

namespace {

// A place stands out if all others but its neighbours differ by so many times as much.
constexpr int kApart = 2;
constexpr double kStandsOut = 1.3;
// Slope of the alignment over that of the window with itself: 1 where both images show the same.
constexpr double kLeastSlope = 0.8, kMostSlope = 1.25;
// Contrast of the right image over that of the left.
constexpr double kLeastGain = 0.6, kMostGain = 1.6;
constexpr int kPixels = kRowPatchWidth * kRowPatchHeight;
constexpr int kLeastGradient = 200;  ///< mean square, twice the grey levels a pixel

}  // namespace

void RowSearch::setImages(const cv::Mat& left, const cv::Mat& right, double infinity) {
  left_ = left;
  right_ = right;
  infinity_px_ = infinity;
  infinity_ = static_cast<int>(std::floor(infinity / 2));
  toGradients(left, left_gradients_);
  toGradients(right, right_gradients_);
  differences_.resize(static_cast<size_t>(left.cols) + Plane::kSlack);
}

std::unique_ptr<RowSearch> RowSearch::exchanged() const {
  auto other = std::make_unique<RowSearch>(simd_);
  other->setImages(right_, left_, -infinity_px_);
  return other;
}

void RowSearch::toGradients(const cv::Mat& image, Plane& gradients) {
  const cv::Size half(image.cols / 2, image.rows / 2);
  half_.resize(half.width, half.height);
  gradients.resize(half.width, half.height);
  cv::Mat target(half, CV_8UC1, half_.row(0), static_cast<size_t>(half_.stride()));
  cv::resize(image({0, 0, 2 * half.width, 2 * half.height}), target, half, 0, 0, cv::INTER_AREA);
  for (int y = 0; y < half.height; ++y) kernels_.gradientRow(half_.row(y), half.width, gradients.row(y));
}

RowSearch::Place RowSearch::standsOut(const int16_t* differences, int count) {
  const auto least = [&](int begin, int end) {
    int16_t value = INT16_MAX;
    for (int k = begin; k < end; ++k) value = std::min(value, differences[k]);
    return value;
  };
  const int16_t best = least(0, count);
  const auto at = static_cast<int>(std::find(differences, differences + count, best) - differences);
  if (kStandsOut * best > std::min(least(0, at - kApart), least(at + kApart + 1, count))) return {};
  return {at, best};
}

RowSearch::Place RowSearch::searchRow(int x, int y, int rows_below) {
  const int width = left_gradients_.width(), left = x - kRowWindowWidth / 2, top = y - kRowWindowHeight / 2;
  const int right_top = top + rows_below;
  const int begin = std::max(1, left - infinity_ - width / 4),
            end = std::min(left - infinity_ + 2, width - kRowWindowWidth);
  const int lowest = left_gradients_.height() - kRowWindowHeight;
  if (left < 1 || left + kRowWindowWidth >= width || std::min(top, right_top) < 0 ||
      std::max(top, right_top) > lowest || begin >= end)
    return {};
  kernels_.compareRow(left_gradients_.row(top) + left, right_gradients_.row(right_top) + begin,
                      left_gradients_.stride(), end - begin, differences_.data());
  Place place = standsOut(differences_.data(), end - begin);
  if (place.position >= 0) place.position += begin + kRowWindowWidth / 2;
  return place;
}

std::optional<double> RowSearch::disparity(const cv::Point2f& point, double below) {
  const cv::Point at(static_cast<int>(std::lround(point.x)), static_cast<int>(std::lround(point.y)));
  const Place place = searchRow(at.x / 2, at.y / 2, static_cast<int>(std::lround(below / 2)));
  if (place.position < 0) return std::nullopt;
  return align(at, {at.x - 2 * (at.x / 2 - place.position), at.y}, below);
}

std::optional<int> RowSearch::rowsBelow(const cv::Point2f& point, int reach) {
  const auto x = static_cast<int>(std::lround(point.x)), y = static_cast<int>(std::lround(point.y));
  of_rows_.clear();
  for (int below = -reach / 2; below <= reach / 2; ++below) {
    of_rows_.push_back(searchRow(x / 2, y / 2, below).difference);
  }
  const Place best = standsOut(of_rows_.data(), static_cast<int>(of_rows_.size()));
  if (best.position < 0 || best.difference == INT16_MAX) return std::nullopt;
  return 2 * (best.position - reach / 2);
}

/// Lucas and Kanade's step along the row: with linear interpolation its sum is known between whole pixels, and its root
/// needs no iteration.
std::optional<double> RowSearch::align(const cv::Point& point, const cv::Point& right_point, double below) const {
  constexpr int kReach = kRowShifts / 2;
  const auto whole = static_cast<int>(std::floor(below));
  const auto share = static_cast<uint16_t>((below - whole) * kWholeRow);
  const int left = point.x - kRowPatchWidth / 2, top = point.y - kRowPatchHeight / 2;
  const int right = right_point.x - kRowPatchWidth / 2 - kReach,
            right_top = right_point.y - kRowPatchHeight / 2 + whole;
  if (std::min(left - 1, right) < 0 || std::max(left + 1, right) + kRowPixels > left_.cols ||
      std::min(top, right_top) < 0 || std::max(top, right_top + (share > 0)) + kRowPatchHeight > left_.rows)
    return std::nullopt;
  const RowSums of =
      patchKernels(simd_).sumRows({left_.ptr(top) + left - 1, static_cast<ptrdiff_t>(left_.step)},
                                  {right_.ptr(right_top) + right, static_cast<ptrdiff_t>(right_.step)}, share);
  const double mean = static_cast<double>(of.gradient) / kPixels;
  const double square = of.gradient_gradient - mean * mean * kPixels;
  if (square < kLeastGradient * kPixels) return std::nullopt;
  const double own_sum = of.own, middle_sum = of.there[kReach];
  const double gain =
      std::sqrt((of.middle_middle - middle_sum * middle_sum / kPixels) / (of.own_own - own_sum * own_sum / kPixels));
  if (!(gain > kLeastGain && gain < kMostGain)) return std::nullopt;
  const double zero = of.gradient_own - mean * own_sum;
  double sums[kRowShifts];  // of gradient times difference, zero where the windows agree
  for (int k = 0; k < kRowShifts; ++k) {
    const double sum = of.gradient_there[k] - mean * of.there[k];
    sums[k] = sum / gain - zero;
  }
  std::optional<double> nearest;  // shift
  for (int k = 0; k + 1 < kRowShifts; ++k) {
    // The gradients are differences over two pixels.
    const double slope = 2 * (sums[k + 1] - sums[k]) / square;
    if (sums[k] > 0 || sums[k + 1] <= 0 || slope < kLeastSlope || slope > kMostSlope) continue;
    const double shift = k - sums[k] / (sums[k + 1] - sums[k]) - kReach;
    if (!nearest || std::abs(shift) < std::abs(*nearest)) nearest = shift;
  }
  if (!nearest) return std::nullopt;
  return point.x - (right_point.x + *nearest);
}

}  // namespace gms_ransac
