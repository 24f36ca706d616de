// The votes of one shifted grid: how many matches go from each left cell to its favourite right cell, and how many of
// the neighbours' matches agree with that (Bian et al., CVPR 2017, section 3).
#pragma once

#include <cstdint>
#include <vector>

#include "motion_statistics/cell_grid.h"
#include "motion_statistics/half_cell_order.h"

namespace gms_ransac {

struct VotingRule {
  double alpha = 6.0;       ///< threshold = alpha * sqrt(mean number of matches in the neighbouring left cells)
  bool five_cells = false;  ///< the centre and its four direct neighbours vote, instead of all nine
  bool rotation = false;    ///< also try the neighbourhood turned by 45 degrees (five cells: 90) and its multiples

  int firstNeighbor() const { return five_cells ? 1 : 0; }  ///< ring position
  int ringStep() const { return five_cells ? 2 : 1; }       ///< between voting neighbours, and between rotations
  int rotations() const { return rotation ? 8 / ringStep() : 1; }
};

/// Columns are indexed by left cell of the padded grid; rotation `i` of the rule turns by i * ringStep() * 45 degrees.
class GridVotes {
 public:
  /// `left` is the grid the matches were sorted by in `count`, `right` the one their right cells belong to.
  void setGrids(const CellGrid& left, const CellGrid& right);
  /// Counts the matches of each cell of the grid shifted by half a cell where `shift_x`, `shift_y` are 1.
  /// `drop_first`: the half cells that the shift leaves over at the left and the top take no part.
  void count(const HalfCellOrder& order, int shift_x, int shift_y, bool drop_first);
  /// Decides on every cell pair, after `count`.
  void decide(const VotingRule& rule);

  int best(int cell) const { return best_[cell]; }               ///< favourite right cell; 0 (border) if none
  unsigned accepted(int cell) const { return accepted_[cell]; }  ///< bit i: accepted under rotation i
  int score(int cell, int rotation) const { return score_[static_cast<size_t>(cell) * rule_.rotations() + rotation]; }
  double threshold(int cell, int rotation) const;  ///< what that score was compared with

 private:
  struct Vote {
    int32_t cell;   ///< right cell
    int32_t count;  ///< matches that go there
  };
  /// Consecutive places of the order: their right cells.
  struct Stretch {
    const int32_t* begin = nullptr;
    const int32_t* end = nullptr;
  };
  /// Counts one cell and appends its votes at `vote_end`; returns the new end.
  int countCell(int cell, const Stretch (&stretches)[2], int vote_end);
  void boundScores();
  void collectScores();
  /// So that the neighbours of cell -(stride + 1), where nobody votes, can be looked up.
  int histogramMargin() const { return 2 * (right_.stride() + 1); }

  CellGrid left_, right_;
  VotingRule rule_;
  std::vector<int32_t> members_, best_, best_count_;
  std::vector<int32_t> left_neighbors_[2];  ///< voting cells inside the left grid, with nine and with five cells
  std::vector<uint8_t> right_inside_;       ///< per right cell: all its neighbours are inside the grid
  std::vector<double> full_threshold_;      ///< threshold if all right neighbours are inside their grid
  std::vector<int32_t> target_;  ///< best_ of the cells that can still be accepted, otherwise a place without votes
  std::vector<int32_t> score_;   ///< cells x rotations
  std::vector<uint8_t> accepted_;
  std::vector<Vote> votes_;           ///< distinct right cells of each left cell, one left cell after the other
  std::vector<int32_t> votes_begin_;  ///< per left cell, and the end
  std::vector<int32_t> histogram_;    ///< one row of the count matrix behind a margin; all zero between uses
};

}  // namespace gms_ransac
