#include "ransac/ordering.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace gms_ransac {

namespace {

constexpr uint32_t kMaxScore = (1u << 14) - 1;  ///< 14 of the 32 bits of a key; larger scores tie
constexpr uint32_t kMaxRatio = (1u << 9) - 1;

// The packed keys are sorted by one byte after the other.
constexpr int kDigits = 4, kDigitValues = 256;

size_t digit(uint32_t key, int d) { return key >> 8 * d & (kDigitValues - 1); }

/// The keys of one match packed so that a smaller number is a better match.
uint32_t packKeys(const PointPairs& pairs, SortKey key, size_t row) {
  const uint32_t distance = pairs.distance[row], second = pairs.second_distance[row];
  const uint32_t ratio = second > 0 ? std::min(kMaxRatio, distance * kMaxRatio / second) : kMaxRatio;
  const uint32_t score =
      kMaxScore - std::min<uint32_t>(kMaxScore, static_cast<uint32_t>(std::max(0, pairs.score[row])));
  switch (key) {
    case SortKey::kScore:
      return score << 18 | distance << 9 | ratio;
    case SortKey::kRelativeScore: {
      constexpr float kSteps = 256;  // per unit; a relative score is rarely above 20
      const float steps = std::min(std::max(0.f, pairs.relative_score[row]) * kSteps, static_cast<float>(kMaxScore));
      return (kMaxScore - static_cast<uint32_t>(steps)) << 18 | distance << 9 | ratio;
    }
    case SortKey::kDistance:
      return distance << 23 | ratio << 14 | score;
    case SortKey::kLoweRatio:
      return ratio << 23 | distance << 14 | score;
  }
  return 0;
}

}  // namespace

void Ordering::sort(const PointPairs& pairs, std::optional<SortKey> key, std::vector<int>& order) {
  const auto n = static_cast<size_t>(pairs.size());
  order.resize(n);
  if (!key || n == 0) {
    std::iota(order.begin(), order.end(), 0);
    return;
  }

  entries_.resize(n);
  scratch_.resize(n);
  std::array<std::array<uint32_t, kDigitValues>, kDigits> first{};
  for (size_t row = 0; row < n; ++row) {
    const uint32_t packed = packKeys(pairs, *key, row);
    entries_[row] = {packed, static_cast<int>(row)};
    for (int d = 0; d < kDigits; ++d) ++first[d][digit(packed, d)];
  }
  // Least significant digit first: each pass is stable, so equal keys stay in the order of their rows.
  for (int d = 0; d < kDigits; ++d) {
    std::array<uint32_t, kDigitValues>& place = first[d];
    if (place[digit(entries_.front().key, d)] == n) continue;  // all alike
    uint32_t sum = 0;
    for (uint32_t& count : place) sum += std::exchange(count, sum);
    for (const Entry& entry : entries_) scratch_[place[digit(entry.key, d)]++] = entry;
    entries_.swap(scratch_);
  }
  for (size_t rank = 0; rank < n; ++rank) order[rank] = entries_[rank].row;
}

}  // namespace gms_ransac
