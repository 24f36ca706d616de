// The 7x7 Gaussian of sigma 2 that cv::ORB applies to a level before it compares pixels.
#pragma once

#include <vector>

#include "features/corner_detector.h"
#include "features/kernels.h"
#include "features/plane.h"

namespace gms_ransac {

class Blur {
 public:
  /// Blurs what the binary tests at `corners` may read, in blocks; elsewhere the target is unspecified. `corners` are
  /// in row order, kDescriptorRadius from the sides. Bit for bit OpenCV's result on processors with FMA
  /// (BORDER_REFLECT_101).
  void apply(const Plane& source, const std::vector<Corner>& corners, const FeatureKernels& kernels, Plane& target);

  void reserve(int width);

 private:
  struct Run {
    int first, last;
  };

  void collectRuns(int y, int width);

  std::vector<float> storage_;       ///< two rows of pixels, then a ring of horizontally filtered rows, on cache lines
  std::vector<int> wanted_down_to_;  ///< last row wanted of each block of columns
  std::vector<Run> runs_;
};

}  // namespace gms_ransac
