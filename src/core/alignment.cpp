#include "alignment.h"

#include <cmath>

#include "matching/aligned_points.h"

namespace gms_ransac {

namespace {

/// Matches that are aligned, at most: all gain a point of AUC5 and take three times the time
/// (doc/measured/constants.md).
constexpr int kMostAligned = 300;

Eigen::Vector2f vectorOf(const cv::Point2f& point) { return {point.x, point.y}; }

}  // namespace

void Alignment::align(const Frame& reference, const Frame& current, const Camera& camera, MatchResult& result) {
  if (reference.image.empty() || current.image.empty()) return;
  choose(result, current.features.image_size);
  PointPairs& pairs = result.pairs;
  pairs.aligned.assign(result.matches.size(), 0);
  for (const int chosen : chosen_) {
    const auto row = static_cast<size_t>(chosen);
    const cv::Point2f& keypoint = reference.features.keypoints[static_cast<size_t>(result.matches[row].reference)].pt;
    const PointToAlign point = pointToAlign(keypoint, result.current_pixel[row], 1);
    const auto found = gms_ransac::align(reference.image, current.image, point, kInNextImage, simd_);
    if (!found) continue;
    const Eigen::Vector2f from_centre = vectorOf(keypoint) - vectorOf(point.pixel);
    const Eigen::Vector2f place = found->centre + found->shape * from_centre;
    const cv::Point2f pixel(place.x(), place.y()), undistorted = camera.undistort(pixel);
    if (std::isnan(undistorted.x)) continue;
    result.current_pixel[row] = pixel;
    pairs.x_current[row] = undistorted.x;
    pairs.y_current[row] = undistorted.y;
    if (!pairs.row_current.empty()) pairs.row_current[row] = pixel.y;
    pairs.aligned[row] = 1;
  }
}

void Alignment::choose(const MatchResult& result, const cv::Size& image) {
  const size_t matches = result.current_pixel.size();
  count_.assign(kSpreadGridSide * kSpreadGridSide, 0);
  rank_.resize(matches);
  for (size_t row = 0; row < matches; ++row) {
    rank_[row] = count_[static_cast<size_t>(spreadCell(result.current_pixel[row], image))]++;
  }
  count_.assign(matches, 0);
  for (const int rank : rank_) ++count_[static_cast<size_t>(rank)];
  int whole = 0, left = kMostAligned;  // ranks of which every match is chosen, and places for the next rank
  for (; left > 0 && static_cast<size_t>(whole) < matches && count_[static_cast<size_t>(whole)] <= left; ++whole)
    left -= count_[static_cast<size_t>(whole)];
  chosen_.clear();
  for (size_t row = 0; row < matches; ++row) {
    if (rank_[row] < whole || (rank_[row] == whole && left-- > 0)) chosen_.push_back(static_cast<int>(row));
  }
}

}  // namespace gms_ransac
