// A pose with what is known of it, for whatever is compared with it.
#pragma once

#include "judgement/match_noise.h"
#include "judgement/pose_uncertainty.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

struct JudgedPose {
  const TwoViewPose& pose;
  const TwoViewPoints& points;
  const MatchNoise& noise;   ///< measured at the pose
  const PoseSpread& spread;  ///< likewise, before other motions widen it
};

}  // namespace gms_ransac
