// Evidence for a match in addition to its neighbours' votes: alike descriptors, and a keypoint that rotates and changes
// octave as most do. Not part of any paper.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {

class MatchEvidence {
 public:
  /// Log-odds from which a match is kept: of -1.5 to 0.5 the one with the best poses.
  static constexpr float kLeastLogOdds = -1.f;

  /// Finds the most common rotation and change of octave of the matches. Returns how many matches vote.
  int prepare(const Features& reference, const Features& current, const std::vector<Match>& matches);
  /// Per match: 1 unless its keypoint rotates otherwise than most.
  const std::vector<uint8_t>& voting() const { return voting_; }

  /// Log-odds that match `i` is right. `votes`: its score over the square root of the mean matches of neighbouring
  /// cells.
  float logOdds(int i, const Match& match, float votes) const;

 private:
  std::vector<uint8_t> voting_;
  std::vector<float> rotation_;         ///< degrees away from the common rotation, 0 if unknown
  std::vector<uint8_t> octave_change_;  ///< octaves away from the common change
};

}  // namespace gms_ransac
