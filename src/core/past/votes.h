// What is seen beside the matches that the filter kept: distinctive matches that agree with a motion or not, and
// keypoints that are found again or not.
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
  /// Adds what cells of the spread grid say of the motion and of the rotation of `result` to its evidence. Matches that
  /// the filter kept agree with each other; those that it rejected are heard here.
  void collect(const Features& reference, const Features& current, const Camera& camera, MatchResult& result);

 private:
  std::vector<int32_t> closest_;  ///< least distance of the raw matches of each current keypoint
};

}  // namespace gms_ransac
