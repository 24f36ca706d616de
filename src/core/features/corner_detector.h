// FAST-9/16 corners of one pyramid level with their contrast, after 3x3 non-maximum suppression.
#pragma once

#include <vector>

#include "features/kernels.h"
#include "features/plane.h"

namespace gms_ransac {

struct Corner {
  uint16_t x, y;     ///< pixels of the level
  uint8_t contrast;  ///< 1..255; cv::FAST's response is one less
  uint8_t strength;  ///< by which corners are ranked, from the contrast here and at the eight neighbours
};

class CornerDetector {
 public:
  /// Finds every corner at least `border` (>= 4) pixels from the sides above `floors`, row by row; with no floor of
  /// strength those of cv::FAST at threshold floors.contrast with suppression. Returns how many it met, weaker ones
  /// included.
  size_t detect(const Plane& image, int border, const CornerFloors& floors, const FeatureKernels& kernels,
                std::vector<Corner>& corners);

  /// Contrasts after detect(), zero where not above the floor: of the corners and their neighbours, and of every other
  /// pixel where strength has no floor; valid one pixel beyond the border.
  const Plane& contrast() const { return contrast_; }

 private:
  Plane contrast_;
  std::vector<uint16_t> columns_;     ///< of one row
  std::vector<uint8_t> strength_;     ///< of one row
  std::vector<uint8_t> passed_over_;  ///< of three rows, a ring; see BlockRow
  std::vector<uint16_t> candidates_;  ///< the same
};

constexpr int kEdgeRadius = 7;  ///< pixels of the level, of the square in which directions are weighed

/// Keeps corners where the image varies in every direction: the smaller eigenvalue of the structure tensor (Förstner &
/// Gülch 1987) is at least a twentieth of the larger. Corners must lie more than kEdgeRadius from the sides.
void removeEdgePoints(const Plane& image, std::vector<Corner>& corners);

}  // namespace gms_ransac
