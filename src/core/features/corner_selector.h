// Chooses which corners of a level become keypoints: strong ones, spread over the image.
#pragma once

#include <cstdint>
#include <vector>

#include "features/corner_detector.h"

namespace gms_ransac {

class CornerSelector {
 public:
  /// Keeps `quota` of the corners, in their order, and drops the rest. A corner competes with its strength times a
  /// weight that falls with its rank among those of its cell: the best of every cell come first, however faint, and
  /// only then does a strongly textured cell get more. Linear in the number of corners.
  void select(int width, int height, int quota, std::vector<Corner>& corners);

 private:
  void sortByStrength(const std::vector<Corner>& corners);
  void rankWithinCells(int width, int height, int quota, const std::vector<Corner>& corners);
  void keepBest(int quota, std::vector<Corner>& corners) const;

  std::vector<uint32_t> order_;       ///< corners by falling strength
  std::vector<uint16_t> cell_count_;  ///< corners met so far in each cell
  std::vector<uint16_t> priority_;    ///< of each corner
  std::vector<uint32_t> histogram_;   ///< of the priorities
};

}  // namespace gms_ransac
