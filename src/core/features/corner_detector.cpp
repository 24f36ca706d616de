#include "features/corner_detector.h"

namespace gms_ransac {

namespace {
constexpr int kColumnSlack = 16;  // what vector code may write past the last column
}

void CornerDetector::detect(const Plane& image, int border, int floor, const FeatureKernels& kernels,
                            std::vector<Corner>& corners) {
  corners.clear();
  const int width = image.width(), height = image.height();
  if (width <= 2 * border || height <= 2 * border) return;
  contrast_.resize(width, height);
  // No two of the maxima touch, so that at most one pixel in four is one.
  columns_.resize(width + kColumnSlack);
  strength_.resize(width + Plane::kSlack);
  corners.reserve(static_cast<size_t>(width + 1) * (height + 1) / 4);

  const int end = width - border;
  const auto computeRow = [&](int y) {
    kernels.contrastRow(image.row(y), image.stride(), end + 1, floor, contrast_.row(y));
  };
  computeRow(border - 1);
  computeRow(border);
  for (int y = border; y < height - border; ++y) {
    computeRow(y + 1);
    const uint8_t* row = contrast_.row(y);
    const int count = kernels.maximaRow(row, contrast_.stride(), border, end, columns_.data(), strength_.data());
    for (int i = 0; i < count; ++i) {
      const uint16_t x = columns_[i];
      corners.push_back({x, static_cast<uint16_t>(y), row[x], strength_[x]});
    }
  }
}

}  // namespace gms_ransac
