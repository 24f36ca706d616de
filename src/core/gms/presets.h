// What fills the settings that were left open: the paper's fixed ones, or measured ones where evidence is weighed.
#pragma once

#include <opencv2/core/types.hpp>

#include "gms/cell_grid.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

/// `given` with nothing left open but the grid: the criterion `own` where there is none, then what goes with it, Bian's
/// settings (20 x 20 cells, 6) or the measured ones for evidence (square cells, 1).
MotionStatisticsOptions withDefaults(MotionStatisticsOptions given, Criterion own = Criterion::kThreshold);

/// The grid of the reference image for so many matches that vote: what `options` says, and where that is not set square
/// cells that hold kMatchesPerCell of them.
CellGrid chooseGrid(const MotionStatisticsOptions& options, cv::Size image, int matches);

}  // namespace gms_ransac
