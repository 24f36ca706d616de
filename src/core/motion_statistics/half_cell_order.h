// Matches sorted by the half cell of their reference keypoint: each cell of each of the four shifted grids is then two
// contiguous stretches, so that shifting the grid costs no sorting and no float arithmetic.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "motion_statistics/cell_grid.h"

namespace gms_ransac {

class HalfCellOrder {
 public:
  /// Normalises the keypoints of the matches by the size of their image.
  void setMatches(const Features& reference, const Features& current, const std::vector<Match>& matches,
                  const CellGrid& left);
  /// Sorts the matches that lie on both grids, for this right grid.
  void sort(const CellGrid& right);

  /// Half-cell column and row of the reference keypoint of raw match `i`, clamped to the grid.
  int halfColumn(int i) const { return half_x_[i]; }
  int halfRow(int i) const { return half_y_[i]; }

  int size() const { return static_cast<int>(sorted_.size()); }           ///< matches on both grids
  const std::vector<int32_t>& sorted() const { return sorted_; }          ///< raw match at each place of the order
  const std::vector<int32_t>& rightCells() const { return right_cell_; }  ///< padded right cell at each place
  /// Places [begin, end) of the half cells [column, column_end) of one half row.
  int begin(int half_row, int half_column) const { return start_[half_row * half_columns_ + half_column]; }
  int end(int half_row, int half_column_end) const { return start_[half_row * half_columns_ + half_column_end]; }

 private:
  int half_columns_ = 0, half_rows_ = 0;
  std::vector<float> x_, y_;              ///< of reference, scratch
  std::vector<float> right_x_, right_y_;  ///< of current, normalised to 0..1
  std::vector<int32_t> half_x_, half_y_;  ///< per raw match
  std::vector<uint8_t> on_left_;          ///< per raw match: the reference keypoint lies on the grid
  std::vector<int32_t> unsorted_right_;   ///< per raw match: right cell, or -1
  std::vector<int32_t> sorted_, right_cell_;
  std::vector<int32_t> start_;  ///< first place of each half cell, and the end
};

}  // namespace gms_ransac
