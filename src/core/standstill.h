// Tells a camera that stands still from one that only turns: the static points stay where they were.
#pragma once

#include "gms_ransac/match_result.h"
#include "gms_ransac/past.h"

namespace gms_ransac {

/// Largest displacement of the view as a whole that passes for noise, pixels: that of a keypoint where a camera moves. A
/// vehicle that stands with its engine on moves the view by 0.005 to 0.18 pixels from image to image (EuRoC V1_01).
constexpr double kMostDrift = 0.2;

/// True if the survivors that continue static tracks, by `past`, show a camera at rest, whatever else crosses the view;
/// without a past, or with few tracks, all survivors count. Cells of the spread grid count, not matches.
bool standsStill(const MatchResult& result, const Past* past);

}  // namespace gms_ransac
