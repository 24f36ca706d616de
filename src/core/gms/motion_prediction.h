// Where points of the reference image are expected in the current one, from the first matches or another sensor.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/core/types.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_statistics.h"
#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

/// The cell, of `count` in a row, that holds a position given in cells; the nearest one outside.
inline int cellAt(float position, int count) {
  return static_cast<int>(std::min(std::max(position, 0.f), static_cast<float>(count - 1)));
}

/// Affine motion of the points of one reference cell, pixels of the received images.
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

  /// The cell that holds the point, or the nearest one; null where nothing is expected.
  const CellMotion* at(const cv::Point2f& point, const cv::Size& image) const {
    if (cells.empty()) return nullptr;
    const auto place = [](float position, int side, int count) {
      return cellAt(position * static_cast<float>(count) / static_cast<float>(std::max(side, 1)), count);
    };
    const CellMotion& motion =
        cells[static_cast<size_t>(place(point.y, image.height, rows)) * columns + place(point.x, image.width, columns)];
    return motion.known ? &motion : nullptr;
  }
};

/// Fills `prediction` for a rotation of a calibrated camera with little other motion. A cell is unknown where its rays
/// are or leave the view.
void predictRotation(const RotationPrior& prior, const Camera& camera, MotionPrediction& prediction);

class MotionPredictor {
 public:
  /// Fits an affine displacement to the accepted matches of each cell and its neighbours; cells with too few are
  /// unknown. Valid until the next call.
  const MotionPrediction& predict(const Features& reference, const Features& current, const std::vector<Match>& matches,
                                  const MotionStatistics& statistics);

 private:
  /// Sums over matches at (x, y) with displacement d: 1, x, y, xx, xy, yy, and d, xd, yd, dd of either coordinate of d.
  using Moments = cv::Vec<double, 14>;

  void collect(const Features& reference, const Features& current, const std::vector<Match>& matches,
               const MotionStatistics& statistics);
  /// Fits to the cell and `rings` of cells around it; false without enough support.
  bool fit(int column, int row, int rings, CellMotion& motion) const;

  MotionPrediction prediction_;
  std::vector<Moments> moments_;  ///< of each cell, accepted matches
  std::vector<int> all_;          ///< matches of each cell
  cv::Size2d cell_;               ///< sides, pixels
  float margin_ = 0;
};

}  // namespace gms_ransac
