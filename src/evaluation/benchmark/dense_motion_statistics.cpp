#include "benchmark/dense_motion_statistics.h"

#include <algorithm>
#include <cmath>

#include "gms/cell_grid.h"

namespace gms_ransac {

namespace {

struct Grid {
  int columns, rows;
  int cells() const { return columns * rows; }
};

class DenseRuns {
 public:
  DenseRuns(const MotionStatisticsOptions& options, const Features& reference, const Features& current,
            const std::vector<Match>& matches)
      : options_(options), left_{*options.grid_columns, *options.grid_rows} {
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
    const double columns = left_.columns * ratios[scale], rows = left_.rows * ratios[scale];
    right_.columns = std::max(1, static_cast<int>(truncate ? columns : std::rint(columns)));
    right_.rows = std::max(1, static_cast<int>(truncate ? rows : std::rint(rows)));
    counts_.assign(static_cast<size_t>(left_.cells()) * right_.cells(), 0);
  }

  void run(int rotation, MotionStatistics& result) {
    const size_t n = left_points_.size();
    result.accepted.assign(n, 0);
    result.score.assign(n, 0);
    result.relative_score.assign(n, 0.f);
    for (int shift = 0; shift < 4; ++shift) {
      countMatches(shift & 1, shift >> 1);
      choosePairs();
      for (int left = 0; left < left_.cells(); ++left) verify(left, rotation);
      for (size_t i = 0; i < n; ++i) {
        const int left = match_left_[i];
        if (left < 0 || match_right_[i] != pair_[left] || !pair_accepted_[left]) continue;
        result.accepted[i] = 1;
        if (pair_score_[left] <= result.score[i]) continue;
        result.score[i] = pair_score_[left];
        result.relative_score[i] = static_cast<float>(pair_score_[left] / pair_threshold_[left]);
      }
    }
    result.accepted_count = static_cast<int>(std::count(result.accepted.begin(), result.accepted.end(), 1));
  }

 private:
  int leftCell(const cv::Point2f& point, int shift_x, int shift_y) const {
    const int x = static_cast<int>(std::floor(point.x * static_cast<float>(left_.columns) + 0.5 * shift_x));
    const int y = static_cast<int>(std::floor(point.y * static_cast<float>(left_.rows) + 0.5 * shift_y));
    // A point at the border stays there when the grid is shifted.
    if (x >= left_.columns || y >= left_.rows || point.x >= 1.f || point.y >= 1.f) return -1;
    if (options_.border == GridBorder::kOriginal && ((shift_x && x < 1) || (shift_y && y < 1))) return -1;
    return x + y * left_.columns;
  }

  int rightCell(const cv::Point2f& point) const {
    const int x = static_cast<int>(std::floor(point.x * static_cast<float>(right_.columns)));
    const int y = static_cast<int>(std::floor(point.y * static_cast<float>(right_.rows)));
    const int cell = x + y * right_.columns;
    return cell < right_.cells() ? cell : -1;
  }

  void countMatches(int shift_x, int shift_y) {
    const size_t n = left_points_.size();
    std::fill(counts_.begin(), counts_.end(), 0);
    members_.assign(left_.cells(), 0);
    match_left_.assign(n, -1);
    match_right_.assign(n, -1);
    for (size_t i = 0; i < n; ++i) {
      match_left_[i] = leftCell(left_points_[i], shift_x, shift_y);
      match_right_[i] = rightCell(right_points_[i]);
      if (match_left_[i] < 0 || match_right_[i] < 0) continue;
      ++counts_[static_cast<size_t>(match_left_[i]) * right_.cells() + match_right_[i]];
      ++members_[match_left_[i]];
    }
  }

  void choosePairs() {
    pair_.assign(left_.cells(), -1);
    for (int left = 0; left < left_.cells(); ++left) {
      const int* row = &counts_[static_cast<size_t>(left) * right_.cells()];
      int sum = 0;
      for (int right = 0; right < right_.cells(); ++right) sum += row[right];
      if (sum == 0) continue;
      int most = 0;
      for (int right = 0; right < right_.cells(); ++right) {
        if (row[right] <= most) continue;
        most = row[right];
        pair_[left] = right;
      }
    }
  }

  void verify(int left, int rotation) {
    pair_accepted_.resize(left_.cells());
    pair_score_.resize(left_.cells());
    pair_threshold_.resize(left_.cells());
    pair_accepted_[left] = 0;
    if (pair_[left] < 0) return;
    // The ring of neighbours clockwise from the upper left; a rotation shifts the right one against the left one.
    static const int ring_x[8] = {-1, 0, 1, 1, 1, 0, -1, -1};
    static const int ring_y[8] = {-1, -1, -1, 0, 1, 1, 1, 0};
    const int right = pair_[left];
    int score = 0, pairs = 0;
    double members = 0;
    for (int k = -1; k < 8; ++k) {
      int dx = 0, dy = 0, turned_dx = 0, turned_dy = 0;
      if (k >= 0) {
        const bool diagonal = ring_x[k] != 0 && ring_y[k] != 0;
        if (diagonal && options_.neighborhood == GridNeighborhood::kFive) continue;
        dx = ring_x[k], dy = ring_y[k];
        turned_dx = ring_x[(k + 8 - rotation) % 8], turned_dy = ring_y[(k + 8 - rotation) % 8];
      }
      const int lx = left % left_.columns + dx, ly = left / left_.columns + dy;
      const int rx = right % right_.columns + turned_dx, ry = right / right_.columns + turned_dy;
      if (lx < 0 || ly < 0 || lx >= left_.columns || ly >= left_.rows) continue;
      if (rx < 0 || ry < 0 || rx >= right_.columns || ry >= right_.rows) continue;
      const int neighbor = lx + ly * left_.columns;
      score += counts_[static_cast<size_t>(neighbor) * right_.cells() + rx + ry * right_.columns];
      members += members_[neighbor];
      ++pairs;
    }
    pair_score_[left] = score;
    pair_threshold_[left] = alpha_ * std::sqrt(members / pairs);
    pair_accepted_[left] = score >= pair_threshold_[left];
  }

  MotionStatisticsOptions options_;
  double alpha_ = 0;
  Grid left_, right_;
  std::vector<cv::Point2f> left_points_, right_points_;  ///< normalised
  std::vector<int> counts_;                              ///< left cells x right cells
  std::vector<int> members_, match_left_, match_right_;
  std::vector<int> pair_, pair_score_;
  std::vector<uint8_t> pair_accepted_;
  std::vector<double> pair_threshold_;
};

}  // namespace

void denseMotionStatistics(const MotionStatisticsOptions& given, const Features& reference, const Features& current,
                           const std::vector<Match>& matches, MotionStatistics& statistics) {
  const MotionStatisticsOptions options = withDefaults(given);
  DenseRuns runs(options, reference, current, matches);
  const int rotation_step = options.neighborhood == GridNeighborhood::kFive ? 2 : 1;
  MotionStatistics result;
  statistics.accepted_count = statistics.rotation = statistics.scale = 0;
  statistics.accepted.assign(matches.size(), 0);
  statistics.score.assign(matches.size(), 0);
  statistics.relative_score.assign(matches.size(), 0.f);
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
