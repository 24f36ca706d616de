// The 7x7 Gaussian of sigma 2 that cv::ORB applies to a level before it compares pixels.
#pragma once

#include <vector>

#include "features/corner_detector.h"
#include "features/kernels.h"
#include "features/plane.h"

namespace gms_ransac {

class Blur {
 public:
  /// Blurs what the binary tests at `corners` may read, kDescriptorRadius pixels to each side, in blocks; elsewhere the
  /// target is unspecified. `corners` are in the order of their rows, that far from the sides. Borders are reflected
  /// without repeating the edge pixel (BORDER_REFLECT_101). The sums are fused float products in the order of OpenCV's
  /// own build for processors with FMA: equal to it bit for bit.
  void apply(const Plane& source, const std::vector<Corner>& corners, const FeatureKernels& kernels, Plane& target);

  /// Makes room for images of this width, so that apply() allocates nothing.
  void reserve(int width);

 private:
  /// Columns first..last-1 of a row.
  struct Run {
    int first, last;
  };

  /// Notes that the blocks of columns about a corner are wanted down to its last row.
  void want(const Corner& corner);
  /// Collects in runs_ the blocks that are wanted in row `y` or below.
  void collectRuns(int y, int width);

  std::vector<float> storage_;       ///< two rows of pixels, then a ring of horizontally filtered rows, on cache lines
  std::vector<int> wanted_down_to_;  ///< last row wanted of each block of columns
  std::vector<Run> runs_;
};

}  // namespace gms_ransac
