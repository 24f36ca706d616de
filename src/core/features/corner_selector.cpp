#include "features/corner_selector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace gms_ransac {

namespace {

/// Mean number of keypoints in a cell, and the power of the rank by which the strength is divided
/// (doc/measured/constants.md).
constexpr float kFeaturesPerCell = 120;
constexpr float kRankPower = 0.3;
constexpr float kSmallestCell = 16;  ///< pixels

constexpr int kRanks = 1024;  ///< all further ranks weigh the same
constexpr int kStrengths = 256;
constexpr int kPriorityBits = 12;
constexpr int kWeightOne = 1 << 8;  ///< weight of rank 0; 8 bits of strength times this gives 16 bits

const std::array<uint16_t, kRanks>& rankWeights() {
  static const auto weights = [] {
    std::array<uint16_t, kRanks> by_rank;
    for (int rank = 0; rank < kRanks; ++rank) {
      by_rank[rank] = static_cast<uint16_t>(std::lrint(kWeightOne * std::pow(rank + 1.0, -kRankPower)));
    }
    return by_rank;
  }();
  return weights;
}

uint16_t priorityOf(int strength, int rank_weight) {
  return static_cast<uint16_t>(strength * rank_weight >> (16 - kPriorityBits));
}

}  // namespace

void CornerSelector::reserve(size_t corners, int features) {
  order_.reserve(corners);
  priority_.reserve(corners);
  histogram_.reserve(1 << kPriorityBits);
  cell_count_.reserve(static_cast<size_t>(static_cast<float>(features) / kFeaturesPerCell) + 1);
}

bool CornerSelector::select(int width, int height, int quota, int strength_floor, std::vector<Corner>& corners) {
  if (corners.size() <= static_cast<size_t>(quota)) return strength_floor == 0;
  sortByStrength(width, height, quota, corners);
  rankWithinCells();
  const Cut cut = cutAt(quota);
  // A missing corner ranks behind all of its cell that are there: it would change no priority but have one of its own.
  const int rank = *std::min_element(cell_count_.begin(), cell_count_.end());
  if (strength_floor > 0 && priorityOf(strength_floor, rankWeights()[rank]) >= cut.priority) return false;
  keepBest(quota, cut, corners);
  return true;
}

void CornerSelector::sortByStrength(int width, int height, int quota, const std::vector<Corner>& corners) {
  const float area = static_cast<float>(width) * static_cast<float>(height);
  const float side = std::max(kSmallestCell, std::sqrt(kFeaturesPerCell * area / std::max(quota, 1)));
  const int columns = std::max(1, static_cast<int>(width / side)), rows = std::max(1, static_cast<int>(height / side));
  // Cell of a coordinate by a multiplication in 16.16 fixed point.
  const auto column_step = static_cast<uint64_t>(columns) * 65536 / width;
  const auto row_step = static_cast<uint64_t>(rows) * 65536 / height;
  cell_count_.assign(static_cast<size_t>(columns) * rows, 0);

  std::array<uint32_t, kStrengths> count{};
  for (const Corner& corner : corners) ++count[corner.strength];
  uint32_t sum = 0;
  for (int strength = kStrengths - 1; strength >= 0; --strength) sum += std::exchange(count[strength], sum);
  order_.resize(corners.size());
  for (size_t i = 0; i < corners.size(); ++i) {
    const Corner& corner = corners[i];
    const uint64_t cell = (corner.y * row_step >> 16) * columns + (corner.x * column_step >> 16);
    order_[count[corner.strength]++] = {static_cast<uint32_t>(i), static_cast<uint16_t>(cell), corner.strength};
  }
}

void CornerSelector::rankWithinCells() {
  const auto& weights = rankWeights();
  priority_.resize(order_.size());
  histogram_.assign(1 << kPriorityBits, 0);
  for (const Candidate& candidate : order_) {
    uint16_t& rank = cell_count_[candidate.cell];
    const uint16_t priority = priorityOf(candidate.strength, weights[rank]);
    priority_[candidate.index] = priority;
    rank = static_cast<uint16_t>(rank + (rank < kRanks - 1));
    ++histogram_[priority];
  }
}

CornerSelector::Cut CornerSelector::cutAt(int quota) const {
  // In strides, as long as a whole one fits: the compiler vectorises their sums.
  constexpr int kStride = 64;
  const auto most = static_cast<uint32_t>(quota);
  uint32_t above = 0;
  int end = 1 << kPriorityBits;  // the priorities from here on are above the cut
  for (; end > 0; end -= kStride) {
    const uint32_t* counts = histogram_.data() + end - kStride;
    const uint32_t sum = std::accumulate(counts, counts + kStride, 0u);
    if (above + sum > most) break;
    above += sum;
  }
  Cut cut = {end - 1, above};
  while (cut.above + histogram_[cut.priority] <= most) cut.above += histogram_[cut.priority--];
  return cut;
}

void CornerSelector::keepBest(int quota, const Cut& cut, std::vector<Corner>& corners) const {
  // At the last priority the quota keeps every n-th corner, so that they are spread.
  const uint64_t wanted = quota - cut.above, available = histogram_[cut.priority];
  uint64_t phase = 0;
  size_t kept = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    bool keep = priority_[i] > cut.priority;
    if (priority_[i] == cut.priority) {
      phase += wanted;
      keep = phase >= available;
      if (keep) phase -= available;
    }
    // Written whether kept or not: who is kept cannot be predicted.
    corners[kept] = corners[i];
    kept += keep;
  }
  corners.resize(kept);
}

}  // namespace gms_ransac
