#include "features/corner_detector.h"

namespace gms_ransac {

namespace {
constexpr int kColumnSlack = 16;  // what vector code may write past the last column
constexpr int kRing = 3;          // rows of which it is known what was passed over
}  // namespace

size_t CornerDetector::detect(const Plane& image, int border, const CornerFloors& floors, const FeatureKernels& kernels,
                              std::vector<Corner>& corners) {
  corners.clear();
  const int width = image.width(), height = image.height();
  if (width <= 2 * border || height <= 2 * border) return 0;
  contrast_.resize(width, height);
  // No two of the maxima touch, so that at most one pixel in four is one.
  columns_.resize(width + kColumnSlack);
  strength_.resize(width + Plane::kSlack);
  passed_over_.resize(kRing * (width + 2));
  corners.reserve(static_cast<size_t>(width + 1) * (height + 1) / 4);

  const int end = width - border;
  const auto passedOver = [&](int y) { return passed_over_.data() + y % kRing * (width + 2) + 1; };
  const auto computeRow = [&](int y) {
    kernels.contrastRow(image.row(y), image.stride(), end + 1, floors, contrast_.row(y), passedOver(y));
  };
  size_t met = 0;
  computeRow(border - 1);
  computeRow(border);
  for (int y = border; y < height - border; ++y) {
    computeRow(y + 1);
    uint8_t* row = contrast_.row(y);
    uint8_t* const passed_over[3] = {passedOver(y - 1), passedOver(y), passedOver(y + 1)};
    const MaximaCount count = kernels.maximaRow(image.row(y), row, image.stride(), passed_over, floors, border, end,
                                                columns_.data(), strength_.data());
    met += count.all;
    for (int i = 0; i < count.strong; ++i) {
      const uint16_t x = columns_[i];
      corners.push_back({x, static_cast<uint16_t>(y), row[x], strength_[x]});
    }
  }
  return met;
}

}  // namespace gms_ransac
