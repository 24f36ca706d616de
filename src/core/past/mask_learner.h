// Learns which cells of the view are fixed to the camera. doc/inside/judgement.md explains it.
#pragma once

#include "gms_ransac/camera.h"
#include "gms_ransac/features.h"
#include "gms_ransac/learned_mask.h"
#include "gms_ransac/match_result.h"

namespace gms_ransac {

/// Moves matches with an end in a covered cell, or next to one, from `raw` to `masked`.
void leaveOutMasked(const Features& reference, const Features& current, MatchResult& result);

/// Updates `mask` by a judged pair. If the rotation of `view` moves what is seen, cells whose matches stayed gain
/// evidence of being fixed to the camera, and cells whose matches moved along lose it.
void learnMask(const Features& reference, const Features& current, const Camera& camera, const MatchResult& result,
               const Judgement& view, LearnedMask& mask);

}  // namespace gms_ransac
