// Moves points of the current image to where it shows what the reference image shows around their keypoints, to a tenth
// of a pixel: keypoints are a few tenths of a pixel of their pyramid level off.
#pragma once

#include <vector>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/simd.h"

namespace gms_ransac {

class Alignment {
 public:
  explicit Alignment(SimdLevel simd) : simd_(simd) {}

  /// Aligns a few hundred matches, from all cells of the image alike, and flags them; what is not found again keeps its
  /// keypoint. Does nothing without images.
  void align(const Frame& reference, const Frame& current, const Camera& camera, MatchResult& result);

 private:
  void choose(const MatchResult& result, const cv::Size& image);

  SimdLevel simd_;
  std::vector<int> rank_, count_;  ///< of a match in its cell; matches of a cell, then of a rank
  std::vector<int> chosen_;        ///< rows
};

}  // namespace gms_ransac
