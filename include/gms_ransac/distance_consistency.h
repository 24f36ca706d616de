// Zhu et al. 2019: a second filter behind the motion statistics, which drops matches whose distances do not fit those
// of the others. The paper does not print the criterion; both readings here are ours.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/types.hpp>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

enum class DistanceReading {
  /// The displacement's length lies within 3 robust standard deviations (1.4826 MAD), at least 3 px, of the median over
  /// the 3 x 3 reference cells around it.
  kDisplacement,
  /// The distance to other matches grows from image to image as everyone's does: the median ratio over 8 random
  /// partners
  /// lies within 20 % of the median over all matches.
  kPairwise
};

class DistanceConsistency {
 public:
  explicit DistanceConsistency(DistanceReading reading = DistanceReading::kDisplacement, uint64_t seed = 0)
      : reading_(reading), seed_(seed) {}

  /// Rejects accepted matches of `statistics` (whose columns belong to `matches`): accepted, score and relative_score
  /// become 0. Same seed, same result.
  void apply(const Features& reference, const Features& current, const std::vector<Match>& matches,
             MotionStatistics& statistics);

 private:
  void applyDisplacement(MotionStatistics& statistics);
  void applyPairwise(MotionStatistics& statistics);
  /// `survivor`: position in survivors_.
  void reject(size_t survivor, MotionStatistics& statistics) const;

  DistanceReading reading_;
  uint64_t seed_;
  std::vector<int> survivors_;             ///< indices of the accepted matches
  std::vector<cv::Point2f> from_, to_;     ///< their pixels
  std::vector<float> length_;              ///< of their displacement
  std::vector<int> by_cell_, cell_begin_;  ///< survivors sorted by cell; first one of each cell, and the end
  std::vector<float> pool_, ratio_;
};

}  // namespace gms_ransac
