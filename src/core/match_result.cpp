#include "gms_ransac/match_result.h"

namespace gms_ransac {

Status statusOf(const RobustResult& result, const Camera& camera) {
  if (!result.model_found || result.inlier_count < kMinimumMatches) return Status::kRansacFailed;
  if (!camera.calibrated()) return Status::kUncalibrated;
  if (!result.judgement.pose_found) return Status::kRansacFailed;
  if (result.judgement.translation_observable) return Status::kOk;
  return result.judgement.rotation_observable ? Status::kLowParallax : Status::kMotionUnknown;
}

void MatchResult::clear(Status new_status) {
  status = new_status;
  stationary = false;
  shutter = Shutter();
  keypoints_reference = keypoints_current = inliers = 0;
  raw.clear();
  mask = LearnedMask();
  masked.clear();
  matches.clear();
  pairs.resize(0);
  pairs.rotation_prior.reset();
  pairs.previous_motion.reset();
  pairs.seconds.reset();
  pairs.shutter = {};
  pairs.velocity_before.reset();
  confidence.clear();
  robust.clear();
  inlier.clear();
  times = StageTimes();
  track_id.clear();
  track_length.clear();
}

void MatchResult::reject() {
  status = Status::kRansacFailed;
  inlier.clear();
  inliers = 0;
  robust.reject();
}

}  // namespace gms_ransac
