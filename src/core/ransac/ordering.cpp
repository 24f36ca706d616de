#include "ransac/ordering.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>

namespace gms_ransac {

namespace {

constexpr uint32_t kMaxScore = (1u << 14) - 1;  ///< what is left of 32 bits; larger scores tie
constexpr uint32_t kMaxRatio = (1u << 9) - 1;

/// The keys of one match packed so that a smaller number is a better match.
uint32_t packKeys(const PointPairs& pairs, QualityKey key, size_t i) {
  const uint32_t distance = pairs.distance[i], second = pairs.second_distance[i];
  const uint32_t ratio = second > 0 ? std::min(kMaxRatio, distance * kMaxRatio / second) : kMaxRatio;
  const uint32_t score = kMaxScore - std::min<uint32_t>(kMaxScore, static_cast<uint32_t>(std::max(0, pairs.score[i])));
  switch (key) {
    case QualityKey::kScore:
      return score << 18 | distance << 9 | ratio;
    case QualityKey::kSupport: {
      constexpr float kSteps = 256;  // per unit; a relative score is rarely above 20
      const float steps = std::min(std::max(0.f, pairs.relative_score[i]) * kSteps, static_cast<float>(kMaxScore));
      return (kMaxScore - static_cast<uint32_t>(steps)) << 18 | distance << 9 | ratio;
    }
    case QualityKey::kDistance:
      return distance << 23 | ratio << 14 | score;
    case QualityKey::kRatio:
      return ratio << 23 | distance << 14 | score;
    case QualityKey::kNone:
      break;
  }
  return 0;
}

}  // namespace

QualityKey parseQualityKey(const std::string& name) {
  if (name == "score") return QualityKey::kScore;
  if (name == "support") return QualityKey::kSupport;
  if (name == "distance") return QualityKey::kDistance;
  if (name == "ratio") return QualityKey::kRatio;
  throw std::invalid_argument("unknown quality '" + name + "'; known are score, support, distance, ratio");
}

void Ordering::sort(const PointPairs& pairs, QualityKey key, std::vector<int>& order) {
  const auto n = static_cast<size_t>(pairs.size());
  order.resize(n);
  std::iota(order.begin(), order.end(), 0);
  if (key == QualityKey::kNone) return;

  keys_.resize(n);
  scratch_.resize(n);
  for (size_t i = 0; i < n; ++i) keys_[i] = packKeys(pairs, key, i);
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
