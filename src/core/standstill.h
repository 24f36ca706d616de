// Tells a camera that stands still from one that only turns: the static points stay where they were.
#pragma once

#include "gms_ransac/match_result.h"
#include "gms_ransac/past.h"

namespace gms_ransac {

/// Largest displacement of the view as a whole that passes for noise, pixels.
constexpr double kMostDrift = 0.1;

/// True if the survivors that continue static tracks, by `past`, show a camera at rest, whatever else crosses the view;
/// without a past, or with few tracks, all survivors count. Cells of the spread grid count, not matches.
bool standsStill(const MatchResult& result, const Past* past);

}  // namespace gms_ransac
