// Tells a camera that stands still from one that only rotates: the static points stay where they were.
#pragma once

#include "gms_ransac/features.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/past.h"

namespace gms_ransac {

/// Largest displacement of the view as a whole that passes for noise, pixels: that of a keypoint where a camera moves.
/// A vehicle that stands with its engine on moves the view by 0.005 to 0.18 pixels from image to image (EuRoC V1_01).
constexpr double kMostDrift = 0.2;
/// Fewer static tracks seldom show a motion, or none.
constexpr int kEnoughTracks = 30;
/// A point at rest in the image moved no further, pixels: three deviations of the finest keypoints (0.2 px at best
/// where a camera moves, a tenth of that at rest).
constexpr float kMostMoved = 0.5f;

/// True if most keypoints are matched and the matches that continue static tracks, by `past`, show a camera at rest;
/// bodies may cross the view. All matches are used if there is no past, or if few of them continue static tracks.
/// Evidence is counted by the cells of the spread grid. Keypoints that are equal bit for bit are no evidence: no sensor
/// measures the same twice, so their pixels are a copy.
bool standsStill(const Features& reference, const Features& current, const MatchResult& result, const Past* past);

}  // namespace gms_ransac
