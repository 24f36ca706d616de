// Correspondences with exact labels between two frames of the rendered scene, at a chosen outlier ratio.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "scenes/scene.h"

namespace gms_ransac {

struct SyntheticPairOptions {
  int matches = 1000;
  double outlier_ratio = 0.3;  ///< share of matches whose current position is anywhere in the image, [0, 1]
  double noise = 0.5;          ///< standard deviation of the position noise of the correct ones' current point, pixels
  uint64_t seed = 0;
};

/// Features without descriptors; match i joins reference keypoint i with current keypoint i. Hamming distances are
/// drawn as ORB's are on rendered frames, so that correct and wrong ones overlap.
struct SyntheticPair {
  Features reference, current;
  std::vector<Match> matches;
  std::vector<uint8_t> correct;  ///< one for each match
};

/// Throws std::invalid_argument when the frames show too little in common to draw the correct matches from.
SyntheticPair makeSyntheticPair(const Scene& scene, int reference, int current, const SyntheticPairOptions& options);

}  // namespace gms_ransac
