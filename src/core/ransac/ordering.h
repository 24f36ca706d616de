// Puts matches in order of confidence, for the samplers that try the best first.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

/// What makes a match trustworthy. Ties fall to the next key of: score (high), distance (low), ratio (low), index.
enum class QualityKey {
  kNone,      ///< the order given
  kScore,     ///< motion statistics: matches in support of it in the neighbourhood
  kSupport,   ///< score over the threshold of its neighbourhood, which takes out the density of the texture
  kDistance,  ///< Hamming distance
  kRatio,     ///< distance over second-nearest distance, in steps of 1/511
};

/// "score", "support", "distance", "ratio"; throws std::invalid_argument for another word.
QualityKey parseQualityKey(const std::string& name);

class Ordering {
 public:
  /// Fills `order` with the indices of the matches, most trustworthy first. The result is one and the same everywhere.
  void sort(const PointPairs& pairs, QualityKey key, std::vector<int>& order);

 private:
  std::vector<uint32_t> keys_;
  std::vector<int> scratch_;
};

}  // namespace gms_ransac
