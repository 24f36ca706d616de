#include "gms/match_cells.h"

#include <algorithm>

namespace gms_ransac {

namespace {

/// cells[i] = floor(points[i] * side) between -1 and limit, where everything outside (NaN included) ends up.
void floorOnGrid(const std::vector<float>& points, float side, int limit, std::vector<int32_t>& cells) {
  const size_t n = points.size();
  const float* point = points.data();
  int32_t* cell = cells.data();
  const auto highest = static_cast<float>(limit);
  for (size_t i = 0; i < n; ++i) {
    const float value = point[i] * side;
    const float low = -1.f < value ? value : -1.f;
    const float bounded = low < highest ? low : highest;
    const int32_t truncated = static_cast<int32_t>(bounded);
    cell[i] = truncated - static_cast<int32_t>(bounded < static_cast<float>(truncated));
  }
}

void divide(std::vector<float>& values, int divisor) {
  const auto side = static_cast<float>(divisor);
  for (float& value : values) value /= side;
}

}  // namespace

void MatchCells::setMatches(const Features& reference, const Features& current, const std::vector<Match>& matches,
                            const std::vector<uint8_t>& voting, const CellGrid& left) {
  const size_t n = matches.size();
  left_ = left;
  for (auto* column : {&x_, &y_, &right_x_, &right_y_}) column->resize(n);
  for (auto* column : {&half_x_, &half_y_, &left_half_, &half_, &right_row_, &right_cell_}) column->resize(n);

  const cv::KeyPoint* from = reference.keypoints.data();
  const cv::KeyPoint* to = current.keypoints.data();
  for (size_t i = 0; i < n; ++i) {
    const cv::Point2f p = from[matches[i].reference].pt, q = to[matches[i].current].pt;
    x_[i] = p.x;
    y_[i] = p.y;
    right_x_[i] = q.x;
    right_y_[i] = q.y;
  }
  divide(x_, reference.image_size.width);
  divide(y_, reference.image_size.height);
  divide(right_x_, current.image_size.width);
  divide(right_y_, current.image_size.height);

  // floor(20 x) and floor(20 x + 1/2) both follow exactly from floor(40 x), because doubling a float is exact.
  const int columns = 2 * left.columns, rows = 2 * left.rows;
  floorOnGrid(x_, static_cast<float>(columns), columns, half_x_);
  floorOnGrid(y_, static_cast<float>(rows), rows, half_y_);
  for (size_t i = 0; i < n; ++i) {
    const int x = half_x_[i], y = half_y_[i];
    const bool inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows);
    left_half_[i] = inside ? y * columns + x : unassigned();
  }
  for (size_t i = 0; i < voting.size(); ++i) left_half_[i] = voting[i] ? left_half_[i] : unassigned();
}

void MatchCells::setRightGrid(const CellGrid& right) {
  const int columns = right.columns, rows = right.rows, stride = right.stride(), outside = unassigned();
  floorOnGrid(right_x_, static_cast<float>(columns), columns + 1, right_cell_);
  floorOnGrid(right_y_, static_cast<float>(rows), rows + 1, right_row_);
  const size_t n = right_cell_.size();
  for (size_t i = 0; i < n; ++i) {
    // As published: on the right border of the image, column 20 is column 0 of the next row.
    const int wraps = right_cell_[i] == columns;
    const int x = wraps ? 0 : right_cell_[i], y = right_row_[i] + wraps;
    const bool inside = (x >= 0) & (x < columns) & (y >= wraps) & (y < rows);
    right_cell_[i] = inside ? (y + 1) * stride + x + 1 : 0;
    half_[i] = inside ? left_half_[i] : outside;
  }
}

void MatchCells::leftCells(std::vector<int32_t>& cells) const {
  const size_t n = left_half_.size();
  const int last_column = 2 * left_.columns - 1, last_row = 2 * left_.rows - 1;
  cells.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const int x = std::min(std::max(half_x_[i], 0), last_column), y = std::min(std::max(half_y_[i], 0), last_row);
    cells[i] = (y >> 1) * left_.columns + (x >> 1);
  }
}

}  // namespace gms_ransac
