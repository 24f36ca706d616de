// The 7x7 Gaussian of sigma 2 that cv::ORB applies to a level before it compares pixels.
#pragma once

#include <vector>

#include "features/kernels.h"
#include "features/plane.h"

namespace gms_ransac {

class Blur {
 public:
  /// Borders are reflected without repeating the edge pixel (BORDER_REFLECT_101). Both sides at least 4 pixels. The
  /// sums are fused float products in the order of OpenCV's own build for processors with FMA: equal to it bit for bit.
  void apply(const Plane& source, const FeatureKernels& kernels, Plane& target);

 private:
  std::vector<float> storage_;  ///< one row of pixels, then a ring of horizontally filtered rows, on cache lines
};

}  // namespace gms_ransac
