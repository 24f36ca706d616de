#include "features/corner_selector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace gms_ransac {

namespace {

/// Mean number of keypoints in a cell, and the power of the rank by which the strength is divided: 0 would rank all
/// corners of a level together, a large one would give every cell the same number. See doc/extractor.md.
constexpr float kFeaturesPerCell = 120;
constexpr float kRankPower = 0.3;
constexpr float kSmallestCell = 16;  ///< pixels

constexpr int kRanks = 1024;  ///< all further ranks weigh the same
constexpr int kStrengths = 256;
constexpr int kPriorityBits = 12;
constexpr int kWeightOne = 1 << 8;  ///< weight of rank 0; 8 bits of strength times this gives 16 bits

using RankWeights = std::array<uint16_t, kRanks>;

RankWeights makeRankWeights() {
  RankWeights weights;
  for (int rank = 0; rank < kRanks; ++rank) {
    weights[rank] = static_cast<uint16_t>(std::lrint(kWeightOne * std::pow(rank + 1.0, -kRankPower)));
  }
  return weights;
}

}  // namespace

void CornerSelector::reserve(size_t corners, int features) {
  order_.reserve(corners);
  priority_.reserve(corners);
  histogram_.reserve(1 << kPriorityBits);
  cell_count_.reserve(static_cast<size_t>(static_cast<float>(features) / kFeaturesPerCell) + 1);
}

void CornerSelector::select(int width, int height, int quota, std::vector<Corner>& corners) {
  if (corners.size() <= static_cast<size_t>(quota)) return;
  sortByStrength(width, height, quota, corners);
  rankWithinCells();
  keepBest(quota, corners);
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
  static const RankWeights weights = makeRankWeights();
  priority_.resize(order_.size());
  histogram_.assign(1 << kPriorityBits, 0);
  for (const Candidate& candidate : order_) {
    uint16_t& rank = cell_count_[candidate.cell];
    const auto priority = static_cast<uint16_t>(candidate.strength * weights[rank] >> (16 - kPriorityBits));
    priority_[candidate.index] = priority;
    rank = static_cast<uint16_t>(rank + (rank < kRanks - 1));
    ++histogram_[priority];
  }
}

void CornerSelector::keepBest(int quota, std::vector<Corner>& corners) const {
  uint32_t above = 0;
  int cut = (1 << kPriorityBits) - 1;
  while (above + histogram_[cut] <= static_cast<uint32_t>(quota)) above += histogram_[cut--];
  // Of the priority at which the quota ends only some fit: every so many-th, so that they too are spread.
  const uint64_t wanted = quota - above, available = histogram_[cut];
  uint64_t phase = 0;
  size_t kept = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    bool keep = priority_[i] > cut;
    if (priority_[i] == cut) {
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
