#include "features/edge_points.h"

#include <algorithm>
#include <cstdint>

namespace gms_ransac {

namespace {

constexpr double kLeastRatio = 0.05;  ///< of the eigenvalues; measured in doc/extractor.md

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
