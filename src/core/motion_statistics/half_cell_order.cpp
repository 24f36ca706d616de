#include "motion_statistics/half_cell_order.h"

#include <algorithm>

namespace gms_ransac {

namespace {

/// floor() of a grid coordinate; what cannot be on any grid (NaN included) comes out as -1 or as `limit`.
int floorOnGrid(float value, float limit) {
  const float bounded = std::min(std::max(-1.f, value), limit);
  const int truncated = static_cast<int>(bounded);
  return truncated - (bounded < static_cast<float>(truncated));
}

}  // namespace

void HalfCellOrder::setMatches(const Features& reference, const Features& current, const std::vector<Match>& matches,
                               const CellGrid& left) {
  const size_t n = matches.size();
  half_columns_ = 2 * left.columns;
  half_rows_ = 2 * left.rows;
  for (auto* column : {&x_, &y_, &right_x_, &right_y_}) column->resize(n);
  for (auto* column : {&half_x_, &half_y_, &unsorted_right_}) column->resize(n);
  on_left_.resize(n);

  const cv::KeyPoint* from = reference.keypoints.data();
  const cv::KeyPoint* to = current.keypoints.data();
  for (size_t i = 0; i < n; ++i) {
    const cv::Point2f p = from[matches[i].reference].pt, q = to[matches[i].current].pt;
    x_[i] = p.x;
    y_[i] = p.y;
    right_x_[i] = q.x;
    right_y_[i] = q.y;
  }
  // The published float operations in their order: divide by the image side, multiply by the grid side. Twice that
  // is exact, and so are floor(20 x) and floor(20 x + 1/2) from it.
  const auto left_width = static_cast<float>(reference.image_size.width);
  const auto left_height = static_cast<float>(reference.image_size.height);
  const auto right_width = static_cast<float>(current.image_size.width);
  const auto right_height = static_cast<float>(current.image_size.height);
  const auto columns = static_cast<float>(left.columns), rows = static_cast<float>(left.rows);
  for (size_t i = 0; i < n; ++i) {
    const int hx = floorOnGrid(2.f * (x_[i] / left_width * columns), static_cast<float>(half_columns_));
    const int hy = floorOnGrid(2.f * (y_[i] / left_height * rows), static_cast<float>(half_rows_));
    on_left_[i] = (hx >= 0) & (hx < half_columns_) & (hy >= 0) & (hy < half_rows_);
    half_x_[i] = std::min(std::max(hx, 0), half_columns_ - 1);
    half_y_[i] = std::min(std::max(hy, 0), half_rows_ - 1);
    right_x_[i] /= right_width;
    right_y_[i] /= right_height;
  }
}

void HalfCellOrder::sort(const CellGrid& right) {
  const size_t n = half_x_.size();
  const auto columns = static_cast<float>(right.columns), rows = static_cast<float>(right.rows);
  for (size_t i = 0; i < n; ++i) {
    const int x = floorOnGrid(right_x_[i] * columns, columns), y = floorOnGrid(right_y_[i] * rows, rows);
    const bool inside = (x >= 0) & (x < right.columns) & (y >= 0) & (y < right.rows);
    unsorted_right_[i] = inside ? right.index(x, y) : -1;
    if (!inside) {
      // The published code never checks the range here: column 20 is column 0 of the next row.
      const int cell = x + y * right.columns;
      const bool counted = cell >= 0 && cell < right.columns * right.rows;
      unsorted_right_[i] = counted ? right.index(cell % right.columns, cell / right.columns) : -1;
    }
    if (!on_left_[i]) unsorted_right_[i] = -1;
  }

  start_.assign(static_cast<size_t>(half_columns_) * half_rows_ + 2, 0);
  int32_t* next = start_.data() + 1;  // counts first, then the place of the next match of each half cell
  for (size_t i = 0; i < n; ++i) next[half_y_[i] * half_columns_ + half_x_[i] + 1] += unsorted_right_[i] >= 0;
  for (size_t h = 2; h < start_.size(); ++h) start_[h] += start_[h - 1];
  sorted_.resize(start_.back());
  right_cell_.resize(start_.back());
  for (size_t i = 0; i < n; ++i) {
    if (unsorted_right_[i] < 0) continue;
    const int32_t place = next[half_y_[i] * half_columns_ + half_x_[i]]++;
    sorted_[place] = static_cast<int32_t>(i);
    right_cell_[place] = unsorted_right_[i];
  }
}

}  // namespace gms_ransac
