#include "features/corner_detector.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace gms_ransac {

namespace {
constexpr int kColumnSlack = 16;  // vector code may write so many past the last column
constexpr int kRowsKept = 3;
}  // namespace

size_t CornerDetector::detect(const Plane& image, int border, const CornerFloors& floors, const FeatureKernels& kernels,
                              std::vector<Corner>& corners) {
  corners.clear();
  const int width = image.width(), height = image.height();
  if (width <= 2 * border || height <= 2 * border) return 0;
  contrast_.resize(width, height);
  columns_.resize(width + kColumnSlack);
  strength_.resize(width + Plane::kSlack);
  passed_over_.resize(kRowsKept * (width + 2));
  candidates_.resize(passed_over_.size());
  corners.reserve(static_cast<size_t>(width + 1) * (height + 1) / 4);  // maxima never touch

  const int end = width - border;
  const auto blocks = [&](int y) {
    const int first = y % kRowsKept * (width + 2) + 1;
    return BlockRow{passed_over_.data() + first, candidates_.data() + first};
  };
  const auto computeRow = [&](int y) {
    return kernels.contrastRow(image.row(y), image.stride(), end + 1, floors, contrast_.row(y), blocks(y));
  };
  size_t met = 0;
  computeRow(border - 1);
  int below = computeRow(border);
  for (int y = border; y < height - border; ++y) {
    const int candidates = std::exchange(below, computeRow(y + 1));
    uint8_t* row = contrast_.row(y);
    const MaximaCount count =
        kernels.maximaRow(image.row(y), row, image.stride(), {blocks(y - 1), blocks(y), blocks(y + 1)}, candidates,
                          floors, border, end, columns_.data(), strength_.data());
    met += count.all;
    for (int i = 0; i < count.strong; ++i) {
      const uint16_t x = columns_[i];
      corners.push_back({x, static_cast<uint16_t>(y), row[x], strength_[x]});
    }
  }
  return met;
}

namespace {

constexpr double kLeastRatio = 0.05;  ///< of the eigenvalues; measured in doc/measured/constants.md

/// Sums over the square of the products of Sobel's derivatives. At most 15 * 15 * 1020^2, so that 32 bits hold them.
struct StructureTensor {
  int32_t xx = 0, yy = 0, xy = 0;

  StructureTensor(const uint8_t* centre, ptrdiff_t stride) {
    for (int v = -kEdgeRadius; v <= kEdgeRadius; ++v) {
      const uint8_t* row = centre + v * stride;
      const uint8_t *above = row - stride, *below = row + stride;
      for (int u = -kEdgeRadius; u <= kEdgeRadius; ++u) {
        const int falling = below[u + 1] - above[u - 1], rising = above[u + 1] - below[u - 1];
        const int x = 2 * (row[u + 1] - row[u - 1]) + falling + rising;
        const int y = 2 * (below[u] - above[u]) + falling - rising;
        xx += x * x;
        yy += y * y;
        xy += x * y;
      }
    }
  }

  /// With the eigenvalues a and r a: determinant / trace^2 = r / (1 + r)^2, which grows with r up to 1.
  bool variesInEveryDirection() const {
    const double trace = static_cast<double>(xx) + yy;
    const double determinant = static_cast<double>(xx) * yy - static_cast<double>(xy) * xy;
    return determinant * (1 + kLeastRatio) * (1 + kLeastRatio) >= kLeastRatio * trace * trace;
  }
};

}  // namespace

void removeEdgePoints(const Plane& image, std::vector<Corner>& corners) {
  const auto edge_point = [&](const Corner& corner) {
    return !StructureTensor(image.row(corner.y) + corner.x, image.stride()).variesInEveryDirection();
  };
  corners.erase(std::remove_if(corners.begin(), corners.end(), edge_point), corners.end());
}

}  // namespace gms_ransac
