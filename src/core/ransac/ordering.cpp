#include "ransac/ordering.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace gms_ransac {

namespace {

constexpr uint32_t kMaxScore = (1u << 14) - 1;  ///< what is left of 32 bits; larger scores tie
constexpr uint32_t kMaxRatio = (1u << 9) - 1;

/// The keys of one match packed so that a smaller number is a better match.
uint32_t packKeys(const PointPairs& pairs, SortKey key, size_t i) {
  const uint32_t distance = pairs.distance[i], second = pairs.second_distance[i];
  const uint32_t ratio = second > 0 ? std::min(kMaxRatio, distance * kMaxRatio / second) : kMaxRatio;
  const uint32_t score = kMaxScore - std::min<uint32_t>(kMaxScore, static_cast<uint32_t>(std::max(0, pairs.score[i])));
  switch (key) {
    case SortKey::kScore:
      return score << 18 | distance << 9 | ratio;
    case SortKey::kRelativeScore: {
      constexpr float kSteps = 256;  // per unit; a relative score is rarely above 20
      const float steps = std::min(std::max(0.f, pairs.relative_score[i]) * kSteps, static_cast<float>(kMaxScore));
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
  std::iota(order.begin(), order.end(), 0);
  if (!key) return;

  keys_.resize(n);
  scratch_.resize(n);
  for (size_t i = 0; i < n; ++i) keys_[i] = packKeys(pairs, *key, i);
  // Least significant digit first: each pass is stable, so equal keys stay in the order of their indices.
  constexpr int kDigitBits = 11;
  for (int shift = 0; shift < 32; shift += kDigitBits) {
    std::array<int, (1 << kDigitBits) + 1> first{};
    const auto digit = [&](int i) { return keys_[static_cast<size_t>(i)] >> shift & ((1u << kDigitBits) - 1); };
    for (int i : order) ++first[digit(i) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (int i : order) scratch_[static_cast<size_t>(first[digit(i)]++)] = i;
    order.swap(scratch_);
  }
}

}  // namespace gms_ransac
