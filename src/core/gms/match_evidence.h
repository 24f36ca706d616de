// What speaks for a match beside its neighbours' votes: how alike the descriptors are, and whether its keypoint turns
// and changes octave as most do. Not part of any paper.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"

namespace gms_ransac {

class MatchEvidence {
 public:
  /// Log-odds from which a match is kept. Of -1.5, -1, -0.5, 0 and 0.5 the one with the best poses at the end (kitti_06
  /// at gap 10, 7scenes_redkitchen at 25): the estimator bears wrong matches better than the lack of right ones.
  static constexpr float kLeastLogOdds = -1.f;

  /// Finds the most common turn and change of octave of the matches. Returns how many matches vote.
  int prepare(const Features& reference, const Features& current, const std::vector<Match>& matches);
  /// Per match: 1 unless its keypoint turns quite differently than most.
  const std::vector<uint8_t>& voting() const { return voting_; }

  /// Log-odds that match `i` of those prepared is right. `votes`: its score over the square root of the mean number of
  /// matches in the neighbouring cells, positive.
  float logOdds(int i, const Match& match, float votes) const;

 private:
  std::vector<uint8_t> voting_;
  std::vector<float> turn_;             ///< degrees away from the common turn, 0 if unknown
  std::vector<uint8_t> octave_change_;  ///< octaves away from the common change
};

}  // namespace gms_ransac
