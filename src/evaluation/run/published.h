// What an answer says of itself: the published figures that the evaluation holds against the truth. One place, so that
// another figure is one line.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

/// Probability that a match is right: of raw match `i` of a result, and of pair `i` where an estimator ran without
/// images (`largest_score`: of those pairs).
inline double probabilityOf(const MatchResult& result, size_t i) { return static_cast<double>(result.confidence[i]); }
inline double probabilityOf(const PointPairs& pairs, int32_t largest_score, size_t i) {
  return largest_score > 0 ? static_cast<double>(pairs.score[i]) / largest_score : 1;
}

/// Standard deviation of the inliers' residual, pixels.
inline double sigmaOf(const RobustResult& result) { return result.rms_error_px; }

}  // namespace gms_ransac
