// 16-bit images -> 8-bit grey.
#pragma once

#include <opencv2/core/mat.hpp>

namespace gms_ransac {

/// Cameras put 10, 12 or 14 bits into 16; thermal ones show a scene in a few hundred values far above 0.
class WideImage {
 public:
  /// CV_16UC1 -> CV_8UC1. Scaled by the bits that the brightest value so far needs: that number never shrinks, or the
  /// brightness would jump between frames. Where most of these values are below all of the image's, the range in use is
  /// scaled instead, which stays until an image leaves it or fills little of it.
  cv::Mat toGrey(const cv::Mat& wide);

 private:
  int bits_ = 8;
  double low_ = 0, high_ = 0;  ///< range in use; 0: that of the bits
};

}  // namespace gms_ransac
