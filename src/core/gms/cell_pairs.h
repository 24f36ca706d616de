// One shifted grid decided: to which right cell each left cell goes, and whether its neighbours agree (Bian et al.,
// CVPR 2017, section 3).
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include "gms/cell_grid.h"
#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {

/// Where the keypoints of each match lie: on the left grid by half cells, so that shifting it by half a cell costs no
/// float arithmetic, and on the right grid, which is never shifted, by cells.
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

class VoteMatrix {
 public:
  /// Starts an all-zero matrix of `rows` x `columns` that can count up to `matches` in each entry.
  void begin(int rows, int columns, int matches) {
    columns_ = columns;
    const size_t size = static_cast<size_t>(rows) * columns;
    while (matches >> count_bits_) {
      ++count_bits_;
      capacity_ = 0;
    }
    const uint32_t step = 1u << count_bits_;
    if (size > capacity_ || generation_ > UINT32_MAX - 2 * step) {
      // calloc: of a large matrix the pages that no match falls into are never touched, nor taken from the system.
      capacity_ = std::max(size, capacity_);
      entries_.reset(static_cast<uint32_t*>(std::calloc(capacity_, sizeof(uint32_t))));
      if (!entries_) throw std::bad_alloc();
      generation_ = 0;
    }
    generation_ += step;
  }

  uint32_t* row(int row) { return entries_.get() + static_cast<size_t>(row) * columns_; }
  uint32_t increment(uint32_t& entry) const { return entry = std::max(entry, generation_) + 1; }
  int count(uint32_t entry) const { return static_cast<int>(std::max(entry, generation_) - generation_); }

 private:
  struct Free {
    void operator()(uint32_t* entries) const { std::free(entries); }
  };
  std::unique_ptr<uint32_t, Free> entries_;
  size_t capacity_ = 0;
  int columns_ = 0;
  int count_bits_ = 17;  ///< low bits of an entry; a pair of images has fewer matches than 2^17 as a rule
  uint32_t generation_ = 0;
};

struct VotingRule {
  double alpha = 6.0;       ///< threshold = alpha * sqrt(mean number of matches in the neighbouring left cells)
  bool five_cells = false;  ///< the centre and its four direct neighbours vote, instead of all nine
  bool rotation = false;    ///< also try the neighbourhood rotated by 45 degrees (five cells: 90) and its multiples
  bool drop_first = false;  ///< half cells that a shift leaves over at the left and the top take no part

  int firstNeighbor() const { return five_cells ? 1 : 0; }  ///< ring position
  int ringStep() const { return five_cells ? 2 : 1; }       ///< between voting neighbours, and between rotations
  int rotations() const { return rotation ? 8 / ringStep() : 1; }
};

/// Columns are indexed by cell of the padded left grid, and one past it for matches that do not vote.
class CellPairs {
 public:
  /// `shift`: 0..kShifts-1. While the grid stays only alpha of the rule may change.
  void setLeftGrid(const CellGrid& left, int shift, const VotingRule& rule);
  const std::vector<int32_t>& cellOfHalf() const { return cell_of_half_; }

  /// Counts the matches and decides on every cell pair. The matrix is only used during the call.
  void decide(const MatchCells& matches, const std::vector<int32_t>& half_members, const CellGrid& right,
              VoteMatrix& matrix);

  /// The rotations under which a match of this left cell to that right cell is accepted, one bit each.
  unsigned accepted(int cell, int right) const { return partner_[cell] == right ? accepted_[cell] : 0; }
  /// The score of an accepted match under the rotation given to `choose`.
  struct PairScore {
    int32_t right;  ///< right cell, 0 (a border cell) if the pair was not accepted
    int32_t score;
    float relative_score;  ///< score over threshold
  };
  void choose(int rotation);
  const PairScore& pairScore(int cell) const { return pair_score_[cell]; }

 private:
  void countVotes(const MatchCells& matches, VoteMatrix& matrix);
  double threshold(int cell, int rotation) const;
  int& score(int cell, int rotation) { return score_[static_cast<size_t>(cell) * rule_.rotations() + rotation]; }
  void scorePair(int cell, VoteMatrix& matrix);

  CellGrid left_, right_grid_;
  VotingRule rule_;
  std::vector<int32_t> cell_of_half_;
  std::vector<int32_t> neighbors_;      ///< voting cells inside the left grid, the cell itself included
  std::vector<int32_t> members_;        ///< matches
  std::vector<uint64_t> best_partner_;  ///< matches of the cell most voted for above, its index's complement below
  std::vector<int32_t> partner_votes_;  ///< matches that go to the cell most voted for
  std::vector<int32_t> partner_;        ///< the cell most voted for
  std::vector<double> full_threshold_;  ///< threshold if all right neighbours are inside their grid
  std::vector<int32_t> score_;          ///< cells x rotations
  std::vector<uint8_t> accepted_;
  std::vector<PairScore> pair_score_;
  std::vector<uint8_t> right_inside_;  ///< per right cell: all its neighbours are inside their grid
};

}  // namespace gms_ransac
