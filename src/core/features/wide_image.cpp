#include "features/wide_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

#include <opencv2/core.hpp>

namespace gms_ransac {

namespace {

constexpr int kBinWidth = 16;  // values; levels are linear within
constexpr int kBins = (1 << 16) / kBinWidth;
// Plateau, as a share of the pixels that a bin of the image has in the mean; 0.1 to 0.3 are alike. It was compared with
// a linear range from 5 % to 95 % on KITTI, TUM and EuRoC, drawn as 12 bits, as 16 bits with a shadow, and as thermal
// images. There are up to 8 % fewer inliers, twice as many in tum_fr3_cabinet, and 3 to 10 times as many where the sky
// or half of the view lies apart. Local equalisation (CLAHE) gives no more where values lie together and a tenth of it
// where they do not.
constexpr double kPlateau = 0.2;
// The grey levels are those of so many bins at least. Thermal cameras have a noise of one to five values, which a plain
// image must not show as texture.
constexpr double kFewestBins = 8;
// Share of the grey levels beyond the range that is stated, at each end.
constexpr double kBeyondRange = 0.025;

using Counts = std::array<int, kBins>;

Counts countsOf(const cv::Mat& wide) {
  Counts counts{};
  for (int r = 0; r < wide.rows; ++r) {
    const auto* row = wide.ptr<uint16_t>(r);
    for (int c = 0; c < wide.cols; ++c) ++counts[row[c] / kBinWidth];
  }
  return counts;
}

/// Pixels that a pixel shares its bin with, in the mean.
double usualCount(const Counts& counts) {
  double sum = 0, squares = 0;
  for (const double count : counts) {
    sum += count;
    squares += count * count;
  }
  return squares / std::max(sum, 1.);
}

/// A grey level for every value.
class Levels {
 public:
  explicit Levels(const Counts& counts) : levels_(std::make_unique<Table>()) {
    const double plateau = kPlateau * usualCount(counts);
    double total = 0;
    for (const int count : counts) total += std::min<double>(count, plateau);
    const double shared_by = std::max({total, kFewestBins * plateau, 1.});
    double below = (shared_by - total) / 2;
    const double low = below + kBeyondRange * total, high = below + (1 - kBeyondRange) * total;
    for (int bin = 0; bin < kBins; ++bin) {
      const int first = bin * kBinWidth, last = first + kBinWidth - 1;
      const double step = std::min<double>(counts[bin], plateau) / kBinWidth;
      if (below <= low) range_.low = first;
      if (below < high) range_.high = last;
      for (int value = first; value <= last; ++value, below += step) {
        (*levels_)[value] = static_cast<uint8_t>(std::lround(255 * (below + step / 2) / shared_by));
      }
    }
  }

  uint8_t operator[](uint16_t value) const { return (*levels_)[value]; }
  const ValueRange& range() const { return range_; }

 private:
  using Table = std::array<uint8_t, 1 << 16>;
  std::unique_ptr<Table> levels_;
  ValueRange range_;
};

}  // namespace

cv::Mat wideToGrey(const cv::Mat& wide, ValueRange* range) {
  const Levels levels(countsOf(wide));
  if (range != nullptr) *range = levels.range();
  cv::Mat grey(wide.size(), CV_8UC1);
  for (int r = 0; r < wide.rows; ++r) {
    const auto* from = wide.ptr<uint16_t>(r);
    uint8_t* to = grey.ptr(r);
    for (int c = 0; c < wide.cols; ++c) to[c] = levels[from[c]];
  }
  return grey;
}

}  // namespace gms_ransac
