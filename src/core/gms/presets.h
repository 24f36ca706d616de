// What fills the settings that were left open: the paper's fixed ones, or measured ones where evidence is weighed.
#pragma once

#include <opencv2/core.hpp>

#include "gms/cell_grid.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

/// `given` with Bian's settings where it leaves them open (MotionStatisticsOptions::methodsOwn): 20 x 20 cells, 6.
MotionStatisticsOptions publishedSettings(MotionStatisticsOptions given,
                                          GridNeighborhood neighborhood = GridNeighborhood::kNine);
/// `given` with measured settings where it leaves them open: square cells, weighed evidence.
MotionStatisticsOptions evidenceSettings(MotionStatisticsOptions given);

/// The grid of the reference image for so many matches that vote: what `options` says, and where that is 0 square
/// cells that hold kMatchesPerCell of them.
CellGrid chooseGrid(const MotionStatisticsOptions& options, cv::Size image, int matches);

}  // namespace gms_ransac
