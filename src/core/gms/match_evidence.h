// What speaks for a match beside its neighbours' votes: how alike the descriptors are, and whether its keypoint turns
// and changes pyramid level as most do. Not part of any paper; the filter of method `lo_prosac`.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {

class MatchEvidence {
 public:
  /// Finds the most common turn and change of level of the matches. Returns how many matches take part.
  int prepare(const Features& reference, const Features& current, const std::vector<Match>& matches);
  /// Per match: 1 unless its keypoint turns quite differently than most.
  const std::vector<uint8_t>& takesPart() const { return takes_part_; }

  /// Log-odds that match `i` of those prepared is right, above the least worth keeping: negative for one to drop.
  /// `support`: its score over the square root of the mean number of matches in the neighbouring cells, positive.
  float logOddsToSpare(int i, const Match& match, float support) const;

 private:
  std::vector<uint8_t> takes_part_;
  std::vector<float> turn_;     ///< degrees away from the common turn, 0 if unknown
  std::vector<uint8_t> level_;  ///< pyramid levels away from the common change
};

}  // namespace gms_ransac
