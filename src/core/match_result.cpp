#include "gms_ransac/match_result.h"

#include <iterator>

namespace gms_ransac {

std::string toString(Status status) {
  constexpr const char* kNames[] = {"OK",           "FIRST_FRAME",   "TOO_FEW_KEYPOINTS", "TOO_FEW_MATCHES",
                                    "GMS_REJECTED", "RANSAC_FAILED", "LOW_PARALLAX",      "UNCALIBRATED"};
  const auto i = static_cast<size_t>(status);
  return i < std::size(kNames) ? kNames[i] : "UNKNOWN";
}

Status statusOf(const RobustResult& result, const Camera& camera) {
  if (!result.model_found || result.inlier_count < kMinimumMatches) return Status::kRansacFailed;
  if (!camera.calibrated()) return Status::kUncalibrated;
  if (!result.pose_found) return Status::kRansacFailed;
  return result.translation_observable ? Status::kOk : Status::kLowParallax;
}

void MatchResult::clear(Status new_status) {
  status = new_status;
  stationary = false;
  keypoints_reference = keypoints_current = inliers = 0;
  raw.clear();
  matches.clear();
  pairs.resize(0);
  pairs.rotation_prior.reset();
  pairs.previous_motion.reset();
  pairs.seconds.reset();
  confidence.clear();
  robust.clear();
  times = StageTimes();
}

}  // namespace gms_ransac
