// Zhu et al. 2019: a second filter, which drops matches whose distances do not fit those of the others. The paper does
// not print the criterion; see DistanceReading.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

/// Rejects accepted matches of `statistics`. `seed`: of the random partners of kPairwise.
void rejectInconsistent(DistanceReading reading, uint64_t seed, const Features& reference, const Features& current,
                        const std::vector<Match>& matches, MotionStatistics& statistics);

}  // namespace gms_ransac
