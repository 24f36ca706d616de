#include "tracks/track_selector.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace gms_ransac {

void TrackSelector::Grid::reset(cv::Size image_size, double cell) {
  cell_ = cell;
  columns_ = 1 + static_cast<int>(image_size.width / cell);
  rows_ = 1 + static_cast<int>(image_size.height / cell);
  members_.resize(cells());
  for (std::vector<cv::Point2f>& points : members_) points.clear();
}

int TrackSelector::Grid::cellOf(const cv::Point2f& point) const {
  const int column = std::clamp(static_cast<int>(point.x / cell_), 0, columns_ - 1);
  const int row = std::clamp(static_cast<int>(point.y / cell_), 0, rows_ - 1);
  return row * columns_ + column;
}

bool TrackSelector::Grid::occupied(const cv::Point2f& point, double distance) const {
  const int column = cellOf(point) % columns_, row = cellOf(point) / columns_;
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x) {
      for (const cv::Point2f& other : members_[y * columns_ + x]) {
        if (std::hypot(other.x - point.x, other.y - point.y) < distance) return true;
      }
    }
  }
  return false;
}

const std::vector<int>& TrackSelector::select(const std::vector<TrackedPoint>& points, cv::Size image_size,
                                              const TrackSelectorOptions& options, const Usable& usable) {
  const size_t limit = options.limit > 0 ? options.limit : points.size();
  // As many cells as points are wanted: one in each is the best spread.
  const double share = std::sqrt(image_size.area() / static_cast<double>(std::max<size_t>(limit, 1)));
  grid_.reset(image_size, std::max({options.distance, share, 1.0}));
  sortCandidates(points);
  picked_.clear();
  for (const Candidate& candidate : candidates_) {
    if (picked_.size() == limit) break;
    const cv::Point2f& point = points[candidate.index].current;
    if (grid_.occupied(point, options.distance) || (usable && !usable(points[candidate.index]))) continue;
    grid_.add(point);
    picked_.push_back(candidate.index);
  }
  remember(points);
  return picked_;
}

void TrackSelector::sortCandidates(const std::vector<TrackedPoint>& points) {
  candidates_.clear();
  for (size_t i = 0; i < points.size(); ++i) {
    if (given_way_.count(points[i].id) > 0) continue;
    candidates_.push_back({picked_before_.count(points[i].id) > 0, points[i].length, 0, static_cast<int>(i)});
  }
  const auto before = [](const Candidate& a, const Candidate& b) {
    return std::tie(b.picked_before, b.length, a.rank, a.index) < std::tie(a.picked_before, a.length, b.rank, b.index);
  };
  std::sort(candidates_.begin(), candidates_.end(), before);
  // Among equal tracks the first of every cell come before the second of any.
  std::vector<int> crowd(grid_.cells(), 0);
  for (Candidate& candidate : candidates_) candidate.rank = crowd[grid_.cellOf(points[candidate.index].current)]++;
  std::sort(candidates_.begin(), candidates_.end(), before);
}

void TrackSelector::remember(const std::vector<TrackedPoint>& points) {
  std::unordered_set<uint32_t> picked, given_way;
  for (const int i : picked_) picked.insert(points[i].id);
  for (const TrackedPoint& point : points) {
    const bool known = picked_before_.count(point.id) > 0 || given_way_.count(point.id) > 0;
    if (known && picked.count(point.id) == 0) given_way.insert(point.id);
  }
  picked_before_.swap(picked);
  given_way_.swap(given_way);
}

}  // namespace gms_ransac
