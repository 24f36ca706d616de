#include "benchmark/opencv_baseline.h"

#include <algorithm>
#include <cmath>

#include "gms/cell_grid.h"

namespace gms_ransac {

namespace {

/// The right cell that most matches of a left cell lead to, and whether the neighbours of the two confirm it.
struct CellPair {
  int right = -1;  ///< -1: none
  int score = 0;
  double threshold = 0;
  bool confirms(int cell) const { return right >= 0 && cell == right && score >= threshold; }
};

class DenseRuns {
 public:
  DenseRuns(const MotionStatisticsOptions& options, const Features& reference, const Features& current,
            const std::vector<Match>& matches)
      : options_(options), left_(*options.grid_columns, *options.grid_rows) {
    for (const Match& match : matches) {
      const cv::Point2f p = reference.keypoints[match.reference].pt, q = current.keypoints[match.current].pt;
      left_points_.emplace_back(p.x / reference.image_size.width, p.y / reference.image_size.height);
      right_points_.emplace_back(q.x / current.image_size.width, q.y / current.image_size.height);
    }
    alpha_ = *options.threshold_factor;
    if (options.neighborhood == GridNeighborhood::kFive) alpha_ *= std::sqrt(5.0 / 9.0);
  }

  void setScale(int scale) {
    const double ratios[5] = {1.0, 0.5, 1.0 / std::sqrt(2.0), std::sqrt(2.0), 2.0};
    const bool truncate = options_.border == GridBorder::kOriginal;
    const double columns = left_.width * ratios[scale], rows = left_.height * ratios[scale];
    right_.width = std::max(1, static_cast<int>(truncate ? columns : std::rint(columns)));
    right_.height = std::max(1, static_cast<int>(truncate ? rows : std::rint(rows)));
  }

  void run(int rotation, MotionStatistics& result) {
    const size_t n = left_points_.size();
    result.accepted.assign(n, 0);
    result.score.assign(n, 0);
    result.relative_score.assign(n, 0.f);
    std::vector<CellPair> pairs(left_.area());
    for (int shift = 0; shift < kShifts; ++shift) {
      countMatches(shiftX(shift), shiftY(shift));
      for (int left = 0; left < left_.area(); ++left) pairs[left] = pairOf(left, rotation);
      for (size_t i = 0; i < n; ++i) {
        if (match_left_[i] < 0) continue;
        const CellPair& pair = pairs[match_left_[i]];
        if (!pair.confirms(match_right_[i])) continue;
        result.accepted[i] = 1;
        if (pair.score <= result.score[i]) continue;
        result.score[i] = pair.score;
        result.relative_score[i] = static_cast<float>(pair.score / pair.threshold);
      }
    }
    result.accepted_count = static_cast<int>(std::count(result.accepted.begin(), result.accepted.end(), 1));
  }

 private:
  int leftCell(const cv::Point2f& point, int shift_x, int shift_y) const {
    const int x = static_cast<int>(std::floor(point.x * static_cast<float>(left_.width) + 0.5 * shift_x));
    const int y = static_cast<int>(std::floor(point.y * static_cast<float>(left_.height) + 0.5 * shift_y));
    // A point at the border stays there when the grid is shifted.
    if (x >= left_.width || y >= left_.height || point.x >= 1.f || point.y >= 1.f) return -1;
    if (options_.border == GridBorder::kOriginal && ((shift_x && x < 1) || (shift_y && y < 1))) return -1;
    return x + y * left_.width;
  }

  int rightCell(const cv::Point2f& point) const {
    const int x = static_cast<int>(std::floor(point.x * static_cast<float>(right_.width)));
    const int y = static_cast<int>(std::floor(point.y * static_cast<float>(right_.height)));
    const int cell = x + y * right_.width;
    return cell < right_.area() ? cell : -1;
  }

  int& count(int left, int right) { return counts_[static_cast<size_t>(left) * right_.area() + right]; }

  void countMatches(int shift_x, int shift_y) {
    const size_t n = left_points_.size();
    counts_.assign(static_cast<size_t>(left_.area()) * right_.area(), 0);
    members_.assign(left_.area(), 0);
    match_left_.assign(n, -1);
    match_right_.assign(n, -1);
    for (size_t i = 0; i < n; ++i) {
      match_left_[i] = leftCell(left_points_[i], shift_x, shift_y);
      match_right_[i] = rightCell(right_points_[i]);
      if (match_left_[i] < 0 || match_right_[i] < 0) continue;
      ++count(match_left_[i], match_right_[i]);
      ++members_[match_left_[i]];
    }
  }

  CellPair pairOf(int left, int rotation) {
    const int* row = &count(left, 0);
    const int right = static_cast<int>(std::max_element(row, row + right_.area()) - row);
    if (row[right] == 0) return {};
    CellPair pair;
    pair.right = right;
    double members = members_[left];
    pair.score = row[right];
    int pairs = 1;
    for (size_t k = 0; k < 8; ++k) {
      const bool diagonal = kRingColumn[k] != 0 && kRingRow[k] != 0;
      if (diagonal && options_.neighborhood == GridNeighborhood::kFive) continue;
      const size_t turned = (k + 8 - static_cast<size_t>(rotation)) % 8;  // of the right ring against the left one
      const int lx = left % left_.width + kRingColumn[k], ly = left / left_.width + kRingRow[k];
      const int rx = right % right_.width + kRingColumn[turned], ry = right / right_.width + kRingRow[turned];
      if (lx < 0 || ly < 0 || lx >= left_.width || ly >= left_.height) continue;
      if (rx < 0 || ry < 0 || rx >= right_.width || ry >= right_.height) continue;
      const int neighbor = lx + ly * left_.width;
      pair.score += count(neighbor, rx + ry * right_.width);
      members += members_[neighbor];
      ++pairs;
    }
    pair.threshold = alpha_ * std::sqrt(members / pairs);
    return pair;
  }

  MotionStatisticsOptions options_;
  double alpha_ = 0;
  cv::Size left_, right_;
  std::vector<cv::Point2f> left_points_, right_points_;  ///< normalised
  std::vector<int> counts_;                              ///< left cells x right cells
  std::vector<int> members_, match_left_, match_right_;
};

}  // namespace

void denseMotionStatistics(const MotionStatisticsOptions& given, const Features& reference, const Features& current,
                           const std::vector<Match>& matches, MotionStatistics& statistics) {
  const MotionStatisticsOptions options = withDefaults(given);
  DenseRuns runs(options, reference, current, matches);
  const int rotation_step = options.neighborhood == GridNeighborhood::kFive ? 2 : 1;
  MotionStatistics result;
  statistics.accepted_count = -1;  // less than any run accepts
  for (int scale = 0; scale < (options.scale ? 5 : 1); ++scale) {
    runs.setScale(scale);
    for (int rotation = 0; rotation < (options.rotation ? 8 : 1); rotation += rotation_step) {
      runs.run(rotation, result);
      if (result.accepted_count <= statistics.accepted_count) continue;
      result.rotation = rotation;
      result.scale = scale;
      std::swap(result, statistics);
    }
  }
  const int columns = statistics.grid_columns = *options.grid_columns, rows = statistics.grid_rows = *options.grid_rows;
  statistics.cell.clear();
  for (const Match& match : matches) {
    const cv::Point2f p = reference.keypoints[match.reference].pt;
    const float x = p.x / reference.image_size.width * columns;
    const float y = p.y / reference.image_size.height * rows;
    statistics.cell.push_back(std::min(static_cast<int>(y), rows - 1) * columns +
                              std::min(static_cast<int>(x), columns - 1));
  }
}

}  // namespace gms_ransac
