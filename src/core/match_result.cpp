#include "gms_ransac/match_result.h"

#include <cmath>

namespace gms_ransac {

namespace {

/// Largest standard deviation of a rotation that is published, the three axes together. On recordings 99 % of the right
/// rotations with a claim of at most a degree, and 5 % of the wrong ones, stay below it (doc/inside/judgement.md).
constexpr double kMostRotationSigma = 3 * M_PI / 180;

}  // namespace

Status statusOf(const RobustResult& result, const Camera& camera) {
  if (!result.model_found || result.inlier_count < kMinimumMatches) return Status::kRansacFailed;
  if (!camera.calibrated()) return Status::kUncalibrated;
  if (!result.judgement.pose_found) return Status::kRansacFailed;
  if (result.judgement.translation_observable) return Status::kOk;
  const double variance = result.judgement.pose.covariance.bottomRightCorner<3, 3>().trace();
  return variance <= kMostRotationSigma * kMostRotationSigma ? Status::kLowParallax : Status::kMotionUnknown;
}

void MatchResult::clear(Status new_status) {
  status = new_status;
  stationary = false;
  shutter = Shutter();
  keypoints_reference = keypoints_current = inliers = 0;
  raw.clear();
  matches.clear();
  pairs.resize(0);
  pairs.rotation_prior.reset();
  pairs.previous_motion.reset();
  pairs.seconds.reset();
  pairs.global_shutter = false;
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
