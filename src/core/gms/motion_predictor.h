// From the first matches of a pair to where its other points are to be searched.
#pragma once

#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_prediction.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

class MotionPredictor {
 public:
  /// Fits the displacements of the accepted matches, in the grid of the statistics: for each cell an affine function to
  /// the matches of the cell and its neighbours. A cell with too few of them is not known, nor is any where the
  /// statistics accept no more than they do by chance. Valid until the next call.
  const MotionPrediction& predict(const Features& reference, const Features& current, const std::vector<Match>& matches,
                                  const MotionStatistics& statistics);

 private:
  /// Sums over the matches of a cell, from which a straight line is fitted: positions and displacements.
  struct Moments {
    double count = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    struct Axis {
      double d = 0, xd = 0, yd = 0, dd = 0;
    } axis[2];

    void add(const cv::Point2f& position, const cv::Point2f& displacement);
    void add(const Moments& other);
  };

  void collect(const Features& reference, const Features& current, const std::vector<Match>& matches,
               const MotionStatistics& statistics);
  void fitCells();
  /// Fits to the cell and `rings` of cells around it; false without enough support.
  bool fit(int column, int row, int rings, CellMotion& motion) const;

  MotionPrediction prediction_;
  std::vector<Moments> moments_;  ///< of each cell, accepted matches
  std::vector<int> all_;          ///< matches of each cell
  cv::Size2d cell_;               ///< sides, pixels
  float margin_ = 0;
};

}  // namespace gms_ransac
