#include "gms/cell_pairs.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

int neighborhoodSum(const int32_t* column, int stride, bool five_cells) {
  const int direct = column[0] + column[-1] + column[1] + column[-stride] + column[stride];
  if (five_cells) return direct;
  return direct + column[-stride - 1] + column[-stride + 1] + column[stride - 1] + column[stride + 1];
}

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

void CellPairs::setLeftGrid(const CellGrid& left, int shift, const VotingRule& rule) {
  rule_ = rule;
  if (left == left_) return;
  left_ = left;
  const size_t cells = left.size() + 1;
  for (auto* column : {&neighbors_, &members_, &partner_votes_, &partner_}) column->assign(cells, 0);
  best_partner_.assign(cells, 0);
  full_threshold_.assign(cells, 0.0);
  accepted_.assign(cells, 0);
  pair_score_.assign(cells, {0, 0, 0.f});
  score_.assign(cells * rule.rotations(), 0);

  std::vector<int32_t>& inside = members_;  // ones inside the grid: their neighbourhood sums are the numbers wanted
  for (int y = 0; y < left.rows; ++y) {
    for (int x = 0; x < left.columns; ++x) inside[left.index(x, y)] = 1;
  }
  for (int cell = left.firstCell(); cell < left.endCell(); ++cell) {
    neighbors_[cell] = std::max(1, neighborhoodSum(&inside[cell], left.stride(), rule.five_cells));
  }

  const int unassigned = left.size();
  cell_of_half_.clear();
  for (int half_y = 0; half_y < 2 * left.rows; ++half_y) {
    for (int half_x = 0; half_x < 2 * left.columns; ++half_x) {
      const int x = (half_x + shiftX(shift)) >> 1, y = (half_y + shiftY(shift)) >> 1;
      const bool left_over = (shiftX(shift) && x == 0) || (shiftY(shift) && y == 0);
      const bool dropped = x == left.columns || y == left.rows || (rule.drop_first && left_over);
      cell_of_half_.push_back(dropped ? unassigned : left.index(x, y));
    }
  }
  cell_of_half_.push_back(unassigned);
}

void CellPairs::decide(const MatchCells& matches, const std::vector<int32_t>& half_members, const CellGrid& right,
                       VoteMatrix& matrix) {
  if (!(right == right_grid_)) {
    right_grid_ = right;
    right_inside_.assign(right.size(), 0);
    for (int y = 1; y + 1 < right.rows; ++y) {
      for (int x = 1; x + 1 < right.columns; ++x) right_inside_[right.index(x, y)] = 1;
    }
  }
  matrix.begin(left_.size() + 1, right.size(), matches.size());
  countVotes(matches, matrix);
  std::fill(members_.begin(), members_.end(), 0);
  for (size_t half = 0; half < half_members.size(); ++half) members_[cell_of_half_[half]] += half_members[half];
  members_[left_.size()] = 0;

  const int stride = left_.stride(), rotations = rule_.rotations();
  for (int cell = left_.firstCell(); cell < left_.endCell(); ++cell) {
    const int members = neighborhoodSum(&members_[cell], stride, rule_.five_cells);
    full_threshold_[cell] = rule_.alpha * std::sqrt(static_cast<double>(members) / neighbors_[cell]);
  }
  for (int cell = left_.firstCell(); cell < left_.endCell(); ++cell) {
    accepted_[cell] = 0;
    if (partner_[cell] == 0) continue;
    // No score exceeds the votes of the neighbours' best partners (except at the border of the right grid).
    const int bound = neighborhoodSum(&partner_votes_[cell], stride, rule_.five_cells);
    if (bound < full_threshold_[cell] && right_inside_[partner_[cell]]) continue;
    scorePair(cell, matrix);
    unsigned accepted = 0;
    for (int rotation = 0; rotation < rotations; ++rotation) {
      accepted |= static_cast<unsigned>(score(cell, rotation) >= threshold(cell, rotation)) << rotation;
    }
    accepted_[cell] = static_cast<uint8_t>(accepted);
  }
}

void CellPairs::countVotes(const MatchCells& matches, VoteMatrix& matrix) {
  std::fill(best_partner_.begin(), best_partner_.end(), 0);
  const int32_t* half_cells = matches.halfCells().data();
  const int32_t* right_cells = matches.rightCells().data();
  const int32_t* cell_of_half = cell_of_half_.data();
  uint64_t* best_partner = best_partner_.data();
  const int n = matches.size();
  for (int i = 0; i < n; ++i) {
    const int cell = cell_of_half[half_cells[i]];
    const auto right = static_cast<uint32_t>(right_cells[i]);
    const uint64_t votes = matrix.increment(matrix.row(cell)[right]);
    // Most votes first, then the lowest cell, in one number without a branch.
    best_partner[cell] = std::max(best_partner[cell], votes << 32 | ~right);
  }
  for (int cell = left_.firstCell(); cell < left_.endCell(); ++cell) {
    const bool any = best_partner[cell] != 0;
    partner_[cell] = any ? static_cast<int32_t>(~static_cast<uint32_t>(best_partner[cell])) : 0;
    partner_votes_[cell] = matrix.count(static_cast<uint32_t>(best_partner[cell] >> 32));
  }
}

void CellPairs::scorePair(int cell, VoteMatrix& matrix) {
  const int left_stride = left_.stride(), right_stride = right_grid_.stride();
  const int row_step = right_grid_.size();
  const uint32_t* centre = matrix.row(cell) + partner_[cell];
  const int own = matrix.count(*centre);
  int32_t* scores = &score_[static_cast<size_t>(cell) * rule_.rotations()];
  const int first = rule_.firstNeighbor(), step = rule_.ringStep();
  if (!rule_.rotation) {
    int score = own;
    for (int k = first; k < 8; k += step) {
      const ptrdiff_t left = kRingRow[k] * left_stride + kRingColumn[k];
      score += matrix.count(centre[left * row_step + kRingRow[k] * right_stride + kRingColumn[k]]);
    }
    scores[0] = score;
    return;
  }
  int by_rotation[8] = {};
  for (int k = first; k < 8; k += step) {
    const uint32_t* around = centre + static_cast<ptrdiff_t>(kRingRow[k] * left_stride + kRingColumn[k]) * row_step;
    for (int j = first; j < 8; j += step) {
      by_rotation[(k - j) & 7] += matrix.count(around[kRingRow[j] * right_stride + kRingColumn[j]]);
    }
  }
  for (int rotation = 0; rotation < rule_.rotations(); ++rotation)
    scores[rotation] = own + by_rotation[rotation * step];
}

void CellPairs::choose(int rotation) {
  for (int cell = left_.firstCell(); cell < left_.endCell(); ++cell) {
    pair_score_[cell] = {0, 0, 0.f};
    if (!(accepted_[cell] >> rotation & 1)) continue;
    const int votes = score(cell, rotation);
    pair_score_[cell] = {partner_[cell], votes, static_cast<float>(votes / threshold(cell, rotation))};
  }
}

double CellPairs::threshold(int cell, int rotation) const {
  const int right = partner_[cell];
  if (right_inside_[right]) return full_threshold_[cell];
  // Some neighbours of the right cell are outside their grid: those pairs do not count.
  int members = members_[cell], pairs = 1;
  for (int k = rule_.firstNeighbor(); k < 8; k += rule_.ringStep()) {
    const int rotated = (k - rotation * rule_.ringStep()) & 7;
    const int neighbor = cell + kRingRow[k] * left_.stride() + kRingColumn[k];
    const int right_neighbor = right + kRingRow[rotated] * right_grid_.stride() + kRingColumn[rotated];
    if (!left_.contains(neighbor) || !right_grid_.contains(right_neighbor)) continue;
    members += members_[neighbor];
    ++pairs;
  }
  return rule_.alpha * std::sqrt(static_cast<double>(members) / pairs);
}

}  // namespace gms_ransac
