// What each method's filter leaves to the package: the paper's fixed settings, and the measured ones of `lo_prosac`.
#pragma once

#include <opencv2/core.hpp>

#include "gms/cell_grid.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

/// `given` with Bian's settings where it leaves them open (MotionStatisticsOptions::methodsOwn): 20 x 20 cells, 6.
MotionStatisticsOptions publishedSettings(MotionStatisticsOptions given,
                                          GridNeighborhood neighborhood = GridNeighborhood::kNine);
/// `given` with the measured settings of `lo_prosac` where it leaves them open: square cells, weighed evidence.
MotionStatisticsOptions evidenceSettings(MotionStatisticsOptions given);

/// The grid of the reference image for so many matches that take part: what `options` says, and where that is 0 square
/// cells that hold kMatchesPerCell of them.
CellGrid chooseGrid(const MotionStatisticsOptions& options, cv::Size image, int matches);

}  // namespace gms_ransac
