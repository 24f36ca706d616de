// One shifted grid decided: to which right cell each left cell goes, and whether its neighbours agree (Bian et al.,
// CVPR 2017, section 3).
#pragma once

#include <cstdint>
#include <vector>

#include "gms/cell_grid.h"
#include "gms/match_cells.h"
#include "gms/vote_matrix.h"

namespace gms_ransac {

struct VotingRule {
  double alpha = 6.0;       ///< threshold = alpha * sqrt(mean number of matches in the neighbouring left cells)
  bool five_cells = false;  ///< the centre and its four direct neighbours vote, instead of all nine
  bool rotation = false;    ///< also try the neighbourhood turned by 45 degrees (five cells: 90) and its multiples
  bool drop_first = false;  ///< half cells that a shift leaves over at the left and the top take no part

  int firstNeighbor() const { return five_cells ? 1 : 0; }  ///< ring position
  int ringStep() const { return five_cells ? 2 : 1; }       ///< between voting neighbours, and between rotations
  int rotations() const { return rotation ? 8 / ringStep() : 1; }
};

/// Columns are indexed by cell of the padded left grid, and one past it for matches that do not vote.
class CellPairs {
 public:
  /// `shift`: 0..kShifts-1. Of the rule only alpha may change while the grid stays.
  void setLeftGrid(const CellGrid& left, int shift, const VotingRule& rule);
  /// Matches whose reference keypoint lies in half cell h belong to cell `cellOfHalf()[h]`.
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
  void sumMembers(const std::vector<int32_t>& half_members);
  double threshold(int cell, int rotation) const;
  double borderThreshold(int cell, int rotation) const;
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
