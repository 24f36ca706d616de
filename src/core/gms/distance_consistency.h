// Zhu et al. 2019: a second filter, which drops matches whose distances do not fit those of the others. The paper does
// not print the criterion; see DistanceReading.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/types.hpp>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

class DistanceConsistency {
 public:
  explicit DistanceConsistency(DistanceReading reading = DistanceReading::kDisplacement, uint64_t seed = 0)
      : reading_(reading), seed_(seed) {}

  /// Rejects accepted matches of `statistics`. Same seed, same result.
  void apply(const Features& reference, const Features& current, const std::vector<Match>& matches,
             MotionStatistics& statistics);

 private:
  void applyDisplacement(MotionStatistics& statistics);
  void applyPairwise(MotionStatistics& statistics);
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
