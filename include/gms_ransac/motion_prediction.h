// Where the points of the reference image are expected in the current one, before they are searched there. Made of the
// first matches of a pair, or of what another sensor says.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/core/types.hpp>

namespace gms_ransac {

/// How the points of one cell of the reference image move: by an affine function of their position, give or take a
/// reach. Pixels of the received images.
struct CellMotion {
  bool known = false;  ///< false: the points may be anywhere
  cv::Point2f center;  ///< position in the reference image at which the displacement is that below
  cv::Point2f displacement;
  cv::Point2f per_x, per_y;  ///< change of the displacement with each pixel to the right, and down
  cv::Point2f reach;         ///< half the sides of the rectangle around the prediction in which the point is expected

  cv::Point2f predict(const cv::Point2f& point) const {
    const cv::Point2f from = point - center;
    return point + displacement + from.x * per_x + from.y * per_y;
  }
};

/// Equal cells over the reference image, row by row; none: nothing is expected.
struct MotionPrediction {
  int columns = 0, rows = 0;
  std::vector<CellMotion> cells;

  /// Of the cell that holds the point, the nearest one where the point is outside the image; null without cells.
  const CellMotion* at(const cv::Point2f& point, const cv::Size& image) const {
    if (cells.empty()) return nullptr;
    const auto place = [](float position, int side, int count) {
      const float cell = std::floor(position * static_cast<float>(count) / static_cast<float>(std::max(side, 1)));
      return static_cast<size_t>(std::min(std::max(cell, 0.f), static_cast<float>(count - 1)));
    };
    return &cells[place(point.y, image.height, rows) * static_cast<size_t>(columns) +
                  place(point.x, image.width, columns)];
  }
};

}  // namespace gms_ransac
