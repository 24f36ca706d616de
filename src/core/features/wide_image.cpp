#include "features/wide_image.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

namespace gms_ransac {

namespace {

// This share of the pixels may lie below the range, and as many above; hot and dead pixels are fewer.
constexpr double kBeyondRange = 0.001;
// Values. Thermal cameras have a noise of one to five; a smaller range would show it as texture.
constexpr double kNarrowest = 128;
// The range in use is widened by this part of it on both sides, to stay longer.
constexpr double kMargin = 0.25;
// An image that fills less than this of the range in use gets a new one.
constexpr double kLeastFilled = 0.25;

struct Range {
  double low, high;
  int brightest;  ///< of all pixels
};

Range rangeOf(const cv::Mat& wide) {
  std::vector<int> count(1 << 16);
  for (int r = 0; r < wide.rows; ++r) {
    const auto* row = wide.ptr<uint16_t>(r);
    for (int c = 0; c < wide.cols; ++c) ++count[row[c]];
  }
  const double beyond = kBeyondRange * static_cast<double>(wide.total());
  size_t low = 0, high = count.size() - 1, brightest = high;
  while (brightest > 0 && count[brightest] == 0) --brightest;
  for (double seen = count[low]; seen <= beyond; seen += count[low]) ++low;
  for (double seen = count[high]; seen <= beyond; seen += count[high]) --high;
  return {static_cast<double>(low), static_cast<double>(high), static_cast<int>(brightest)};
}

}  // namespace

cv::Mat WideImage::toGrey(const cv::Mat& wide) {
  const Range image = rangeOf(wide);
  while (bits_ < 16 && image.brightest >= (1 << bits_)) ++bits_;
  if (image.high > image.low) {  // a blank image tells nothing
    const double width = std::max(image.high - image.low, kNarrowest);
    if (image.low < (high_ > 0 ? 1 : 2) * width) {  // two, or an image in between would switch at every frame
      high_ = 0;
    } else if (image.low < low_ || image.high > high_ || width < kLeastFilled * (high_ - low_)) {
      low_ = image.low - kMargin * width;
      high_ = low_ + (1 + 2 * kMargin) * width;
    }
  }
  const double low = high_ > 0 ? low_ : 0, high = high_ > 0 ? high_ : (1 << bits_) - 1;
  cv::Mat grey;
  wide.convertTo(grey, CV_8U, 255 / (high - low), -255 * low / (high - low));
  return grey;
}

}  // namespace gms_ransac
