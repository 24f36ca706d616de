// Motion statistics as the published implementations compute them: a dense count matrix, cleared, summed and searched
// whole for each of the four grids of each run. The yardstick for the sparse filter's results and for its speed.
#pragma once

#include <vector>

#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

/// Same contract as MotionStatisticsFilter::compute, for a given (not an automatic) grid. Reference keypoints lie in
/// or beyond the right and lower border of their image, not before the left and upper one.
void denseMotionStatistics(const MotionStatisticsOptions& options, const Features& reference, const Features& current,
                           const std::vector<Match>& matches, MotionStatistics& statistics);

}  // namespace gms_ransac
