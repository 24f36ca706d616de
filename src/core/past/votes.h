// Counts evidence that the filtered matches cannot give: whether distinctive raw matches agree with a motion, and
// whether keypoints are found again.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/features.h"
#include "gms_ransac/match_result.h"

namespace gms_ransac {

/// Keeps its storage from pair to pair.
class Votes {
 public:
  /// Lets the cells of the spread grid vote for the motion and the rotation of `result`, and adds the shares to its
  /// evidence. Rejected matches vote, too, because those that the filter kept always agree with each other.
  void collect(const Features& reference, const Features& current, const Camera& camera, MatchResult& result);

 private:
  std::vector<int32_t> closest_;  ///< least distance of the raw matches of each current keypoint
};

}  // namespace gms_ransac
