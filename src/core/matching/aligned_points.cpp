#include "matching/aligned_points.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gms_ransac {

namespace {

constexpr int kAlignCell = 50;  ///< side of a cell, pixels
constexpr int kPerCell = 3;     ///< points; all of them gain nothing on KITTI and take twice the time
// Magnification of the current image, of those that a patch can follow.
constexpr float kLeastMagnification = 0.5F, kMostMagnification = 2;

}  // namespace

PointToAlign pointToAlign(const cv::Point2f& reference, const cv::Point2f& current, float magnification) {
  PointToAlign point;
  point.pixel = cv::Point(static_cast<int>(std::lround(reference.x)), static_cast<int>(std::lround(reference.y)));
  const float scale = std::clamp(magnification, kLeastMagnification, kMostMagnification);
  point.guess.shape *= scale;
  point.guess.centre = {current.x + scale * (static_cast<float>(point.pixel.x) - reference.x),
                        current.y + scale * (static_cast<float>(point.pixel.y) - reference.y)};
  return point;
}

std::optional<PatchPlace> align(const cv::Mat& earlier, const cv::Mat& current, const PointToAlign& point,
                                const PatchSearch& search, SimdLevel simd) {
  Patch patch(simd);
  const Eigen::Vector2f centre(static_cast<float>(point.pixel.x), static_cast<float>(point.pixel.y));
  return patch.cut(earlier, centre) ? patch.find(current, point.guess, search) : std::nullopt;
}

std::vector<int> spreadOut(const std::vector<cv::Point2f>& points, const std::vector<uint32_t>& tracks,
                           const cv::Size& size) {
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto began = [&](int i) { return tracks[i] - 1; };  // of those that are not followed the greatest number
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return began(a) < began(b); });
  const int columns = size.width / kAlignCell + 1, rows = size.height / kAlignCell + 1;
  std::vector<int> count(static_cast<size_t>(columns * rows));
  std::vector<int> chosen;
  for (const int i : order) {
    const int column = std::clamp(static_cast<int>(points[i].x) / kAlignCell, 0, columns - 1);
    const int row = std::clamp(static_cast<int>(points[i].y) / kAlignCell, 0, rows - 1);
    if (count[static_cast<size_t>(row) * static_cast<size_t>(columns) + static_cast<size_t>(column)]++ < kPerCell)
      chosen.push_back(i);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace gms_ransac
