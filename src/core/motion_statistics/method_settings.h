// What each method's filter leaves to the package: the paper's fixed settings, and the measured ones of `fast`.
#pragma once

#include <opencv2/core.hpp>

#include "gms_ransac/method.h"
#include "gms_ransac/motion_statistics.h"
#include "motion_statistics/cell_grid.h"

namespace gms_ransac {

/// `given` with the method's own settings where it leaves them open (MotionStatisticsOptions::methodsOwn).
MotionStatisticsOptions motionStatisticsFor(FilterChoice filter, MotionStatisticsOptions given);

/// The grid of the reference image for so many matches that take part: what `options` says, and where that is 0 square
/// cells that hold kMatchesPerCell of them.
CellGrid chooseGrid(const MotionStatisticsOptions& options, cv::Size image, int matches);

}  // namespace gms_ransac
