// The probabilities of a pose and of its rotation, and the decision that follows from them.
#pragma once

#include "gms_ransac/robust_options.h"
#include "gms_ransac/robust_result.h"

namespace gms_ransac {

/// Computes both probabilities from the evidence of a judgement and decides what is known: the pose, the rotation
/// alone, or neither. Called again whenever a later stage has added evidence.
void decide(const RobustOptions& options, Judgement& judgement);

}  // namespace gms_ransac
