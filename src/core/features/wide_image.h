// 16-bit images -> 8-bit grey.
#pragma once

#include <opencv2/core/mat.hpp>

namespace gms_ransac {

/// The values of a 16-bit image that most of the grey levels show.
struct ValueRange {
  int low = 0, high = 0;
};

/// CV_16UC1 -> CV_8UC1. Cameras put 10, 12 or 14 bits into 16; thermal ones show a scene in a few hundred values far
/// above 0. Plateau equalisation (Vickers, Optical Engineering 35(7), 1996) with a low plateau: values share the grey
/// levels evenly as soon as a tenth of the usual number of pixels has them. So the grey levels go to the values that
/// fill the image, and are linear where these lie close together. Hot pixels, reflectors, telemetry rows, and the gap
/// between a cold sky and warm ground take few.
///
/// Depends on this image alone: comparisons do not depend on brightness, and what blinds one image spoils no other.
cv::Mat wideToGrey(const cv::Mat& wide, ValueRange* range = nullptr);

}  // namespace gms_ransac
