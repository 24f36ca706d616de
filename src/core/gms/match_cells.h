// Where the keypoints of each match lie: on the left grid by half cells, so that shifting it by half a cell costs no
// float arithmetic, and on the right grid, which is never shifted, by cells.
#pragma once

#include <cstdint>
#include <vector>

#include "gms/cell_grid.h"
#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {

class MatchCells {
 public:
  /// Finds the reference half cells of the matches. `voting`: 0 for matches that do not vote; empty: all do.
  void setMatches(const Features& reference, const Features& current, const std::vector<Match>& matches,
                  const std::vector<uint8_t>& voting, const CellGrid& left);
  void setRightGrid(const CellGrid& right);

  int size() const { return static_cast<int>(half_.size()); }
  int unassigned() const { return 4 * left_.columns * left_.rows; }  ///< half cell of matches that do not vote
  const std::vector<int32_t>& halfCells() const { return half_; }
  const std::vector<int32_t>& rightCells() const { return right_cell_; }  ///< of the padded right grid
  /// Cell of reference keypoints in the unshifted left grid, not padded; nearest cell if outside the image.
  void leftCells(std::vector<int32_t>& cells) const;

 private:
  CellGrid left_;
  std::vector<float> x_, y_, right_x_, right_y_;  ///< normalised to 0..1
  std::vector<int32_t> half_x_, half_y_, left_half_, half_;
  std::vector<int32_t> right_row_, right_cell_;
};

}  // namespace gms_ransac
