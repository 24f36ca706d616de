// Chooses which corners of a level become keypoints: strong ones, spread over the image.
#pragma once

#include <cstdint>
#include <vector>

#include "features/corner_detector.h"

namespace gms_ransac {

class CornerSelector {
 public:
  /// Moves the `quota` corners chosen to the front of `corners`, in raster order, and drops the rest. A corner competes
  /// with its strength times a weight that falls with its rank among those of its cell, so that every cell gets its
  /// best ones first, however faint, and only then a strongly textured cell gets more.
  void select(int width, int height, int quota, std::vector<Corner>& corners);

 private:
  std::vector<uint32_t> cell_begin_;
  std::vector<uint32_t> ordered_;  ///< (255 - contrast) << 24 | corner, by cell, then by strength
  std::vector<uint16_t> priority_;
  std::vector<uint32_t> histogram_;
};

}  // namespace gms_ransac
