#include "motion_statistics/grid_votes.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

/// Sum over a cell of the padded grid and its voting neighbours.
int neighborhoodSum(const int32_t* column, int stride, bool five_cells) {
  const int direct = column[0] + column[-1] + column[1] + column[-stride] + column[stride];
  if (five_cells) return direct;
  return direct + column[-stride - 1] + column[-stride + 1] + column[stride - 1] + column[stride + 1];
}

}  // namespace

void GridVotes::setGrids(const CellGrid& left, const CellGrid& right) {
  const size_t cells = left.size();
  if (left != left_) {
    left_ = left;
    for (auto* column : {&members_, &best_, &best_count_, &target_}) column->assign(cells, 0);
    full_threshold_.assign(cells, 0.0);
    accepted_.assign(cells, 0);
    votes_begin_.assign(cells + 1, 0);
    std::vector<int32_t>& inside = target_;  // ones inside the grid: their neighbourhood sums are the wanted numbers
    for (int y = 0; y < left.rows; ++y) {
      for (int x = 0; x < left.columns; ++x) inside[left.index(x, y)] = 1;
    }
    for (const bool five_cells : {false, true}) {
      left_neighbors_[five_cells].assign(cells, 1);
      for (int cell = left.firstCell(); cell < left.endCell(); ++cell) {
        left_neighbors_[five_cells][cell] = std::max(1, neighborhoodSum(&inside[cell], left.stride(), five_cells));
      }
    }
  }
  if (right != right_) {
    right_ = right;
    right_inside_.assign(right.size(), 0);
    for (int y = 1; y + 1 < right.rows; ++y) {
      for (int x = 1; x + 1 < right.columns; ++x) right_inside_[right.index(x, y)] = 1;
    }
    histogram_.assign(static_cast<size_t>(right.size()) + histogramMargin(), 0);
  }
}

void GridVotes::count(const HalfCellOrder& order, int shift_x, int shift_y, bool drop_first) {
  const int half_columns = 2 * left_.columns, half_rows = 2 * left_.rows;
  const int32_t* right_cells = order.rightCells().data();
  votes_.resize(order.size());
  int vote_end = 0;
  int next_cell = 0;
  const auto closeUntil = [&](int cell) {  // cells without matches own no votes
    while (next_cell <= cell) votes_begin_[next_cell++] = vote_end;
  };
  for (int y = 0; y < left_.rows; ++y) {
    const int first_row = std::max(2 * y - shift_y, 0), end_row = std::min(2 * y - shift_y + 2, half_rows);
    for (int x = 0; x < left_.columns; ++x) {
      const int first = std::max(2 * x - shift_x, 0), end = std::min(2 * x - shift_x + 2, half_columns);
      const int cell = left_.index(x, y);
      closeUntil(cell);
      const bool dropped = drop_first && ((shift_x && x == 0) || (shift_y && y == 0));
      Stretch stretches[2] = {};
      for (int row = first_row; row < end_row && !dropped; ++row) {
        stretches[row - first_row] = {right_cells + order.begin(row, first), right_cells + order.end(row, end)};
      }
      vote_end = countCell(cell, stretches, vote_end);
    }
  }
  closeUntil(left_.size());
}

int GridVotes::countCell(int cell, const Stretch (&stretches)[2], int vote_end) {
  int32_t* histogram = histogram_.data() + histogramMargin();
  int members = 0;
  for (const Stretch& stretch : stretches) {
    for (const int32_t* right = stretch.begin; right != stretch.end; ++right) ++histogram[*right];
    members += static_cast<int>(stretch.end - stretch.begin);
  }
  // Most matches first, then the lowest cell: both in one number, so that the maximum needs no branch.
  uint64_t favourite = 0;
  Vote* votes = votes_.data();
  for (const Stretch& stretch : stretches) {
    for (const int32_t* right = stretch.begin; right != stretch.end; ++right) {
      const int32_t votes_here = histogram[*right];
      histogram[*right] = 0;
      favourite = std::max(favourite, static_cast<uint64_t>(votes_here) << 32 | static_cast<uint32_t>(~*right));
      if (votes_here == 0) continue;
      votes[vote_end++] = {*right, votes_here};
    }
  }
  members_[cell] = members;
  best_count_[cell] = static_cast<int32_t>(favourite >> 32);
  best_[cell] = members > 0 ? static_cast<int32_t>(~static_cast<uint32_t>(favourite)) : 0;
  return vote_end;
}

void GridVotes::decide(const VotingRule& rule) {
  rule_ = rule;
  boundScores();
  collectScores();
  const int rotations = rule_.rotations();
  for (int cell = left_.firstCell(); cell < left_.endCell(); ++cell) {
    unsigned accepted = 0;
    if (target_[cell] > 0) {
      for (int rotation = 0; rotation < rotations; ++rotation) {
        accepted |= static_cast<unsigned>(score(cell, rotation) >= threshold(cell, rotation)) << rotation;
      }
    }
    accepted_[cell] = static_cast<uint8_t>(accepted);
  }
}

// No score can exceed the sum of the largest votes of the neighbours, whatever the rotation. Where even that is below
// the threshold the look-ups are saved. At the border of the right grid the threshold may be lower: no bound there.
void GridVotes::boundScores() {
  const int stride = left_.stride();
  const std::vector<int32_t>& neighbors = left_neighbors_[rule_.five_cells];
  for (int cell = left_.firstCell(); cell < left_.endCell(); ++cell) {
    const int members = neighborhoodSum(&members_[cell], stride, rule_.five_cells);
    full_threshold_[cell] = rule_.alpha * std::sqrt(static_cast<double>(members) / neighbors[cell]);
  }
  const int nowhere = -(right_.stride() + 1);
  for (int cell = left_.firstCell(); cell < left_.endCell(); ++cell) {
    const int bound = neighborhoodSum(&best_count_[cell], stride, rule_.five_cells);
    const bool live = best_[cell] > 0 && (bound >= full_threshold_[cell] || !right_inside_[best_[cell]]);
    target_[cell] = live ? best_[cell] : nowhere;
  }
  for (int cell = 0; cell < left_.firstCell(); ++cell) target_[cell] = nowhere;
  for (int cell = left_.endCell(); cell < left_.size(); ++cell) target_[cell] = nowhere;
}

// Each left cell's row of the count matrix is laid out once more and its neighbours read their votes from it.
void GridVotes::collectScores() {
  const int stride = left_.stride(), rotations = rule_.rotations();
  score_.assign(static_cast<size_t>(left_.size()) * rotations, 0);
  int left_ring[8], right_ring[8];
  for (int k = 0; k < 8; ++k) {
    left_ring[k] = kRingRow[k] * stride + kRingColumn[k];
    right_ring[k] = kRingRow[k] * right_.stride() + kRingColumn[k];
  }
  int32_t* histogram = histogram_.data() + histogramMargin();
  for (int cell = left_.firstCell(); cell < left_.endCell(); ++cell) {
    const int begin = votes_begin_[cell], end = votes_begin_[cell + 1];
    if (begin == end) continue;
    for (int i = begin; i < end; ++i) histogram[votes_[i].cell] = votes_[i].count;
    const int own = histogram[target_[cell]];
    for (int rotation = 0; rotation < rotations; ++rotation) score_[cell * rotations + rotation] += own;
    for (int k = rule_.firstNeighbor(); k < 8; k += rule_.ringStep()) {
      const int neighbor = cell - left_ring[k];  // this cell is its neighbour k
      const int32_t* around = histogram + target_[neighbor];
      int32_t* scores = &score_[neighbor * rotations];
      for (int rotation = 0; rotation < rotations; ++rotation) {
        scores[rotation] += around[right_ring[rotatedRing(k, rotation * rule_.ringStep())]];
      }
    }
    for (int i = begin; i < end; ++i) histogram[votes_[i].cell] = 0;
  }
}

double GridVotes::threshold(int cell, int rotation) const {
  const int right = best_[cell];
  if (right_inside_[right]) return full_threshold_[cell];
  int members = members_[cell], pairs = 1;
  for (int k = rule_.firstNeighbor(); k < 8; k += rule_.ringStep()) {
    const int turned = rotatedRing(k, rotation * rule_.ringStep());
    const int neighbor = cell + kRingRow[k] * left_.stride() + kRingColumn[k];
    const int right_neighbor = right + kRingRow[turned] * right_.stride() + kRingColumn[turned];
    if (!left_.contains(neighbor) || !right_.contains(right_neighbor)) continue;
    members += members_[neighbor];
    ++pairs;
  }
  return rule_.alpha * std::sqrt(static_cast<double>(members) / pairs);
}

}  // namespace gms_ransac
