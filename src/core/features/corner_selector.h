// Chooses which corners of a level become keypoints: strong ones, spread over the image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "features/corner_detector.h"

namespace gms_ransac {

class CornerSelector {
 public:
  /// Keeps `quota` of the corners, in their order. A corner competes with its strength times a weight that falls with
  /// its rank in its cell, so the best of every cell come first. `corners` may lack those not stronger than
  /// `strength_floor`; returns false, and drops nothing, if one of them might have been kept.
  bool select(int width, int height, int quota, int strength_floor, std::vector<Corner>& corners);

  void reserve(size_t corners, int features);

 private:
  struct Candidate {
    uint32_t index;
    uint16_t cell;  ///< there is about one for every 120 features asked for
    uint8_t strength;
  };

  void sortByStrength(int width, int height, int quota, const std::vector<Corner>& corners);
  void rankWithinCells();
  /// The priority at which the quota ends, and the number of corners above it.
  struct Cut {
    int priority;
    uint32_t above;
  };
  Cut cutAt(int quota) const;
  void keepBest(int quota, const Cut& cut, std::vector<Corner>& corners) const;

  std::vector<Candidate> order_;      ///< corners by falling strength
  std::vector<uint16_t> cell_count_;  ///< corners met so far in each cell
  std::vector<uint16_t> priority_;    ///< of each corner
  std::vector<uint32_t> histogram_;   ///< of the priorities
};

}  // namespace gms_ransac
