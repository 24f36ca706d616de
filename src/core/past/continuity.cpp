#include "past/continuity.h"

#include <algorithm>
#include <cmath>

#include "judgement/candidates.h"
#include "past/standstill.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

constexpr int kRemembered = 4;  ///< pairs over which a known direction is expected again
/// In a hand one in ten pairs whose direction nothing before shows is wrong, most with near and far exchanged. If the
/// pair before shows it, be it as a guess, one in sixty is. Certain to half the limit, the others are as good.
constexpr double kShown = 30 * M_PI / 180;
constexpr double kUsualInterval = 1. / 30;  ///< seconds between images without stamps
constexpr float kLikelyStatic = 0.5f;       ///< least probability of a match whose keypoint is static

bool isSame(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.dot(b) > std::cos(kOtherDirection); }

/// The answer has the direction that the pairs before it had.
bool continues(const RobustResult& answer, const Past& past) {
  return past.steady > 0 && isSame(answer.judgement.pose.t, past.direction);
}

/// Remembers directions in the axes of the current camera, and what the pair shows of the shutter.
void remember(const MatchResult& result, Past& past) {
  const RobustResult& robust = result.robust;
  past.motion = robust.optimum;
  const Eigen::Matrix3d to_current = robust.judgement.pose.R.transpose();
  past.current_guess =
      robust.judgement.pose_found ? Eigen::Vector3d(to_current * robust.judgement.pose.t) : Eigen::Vector3d::Zero();
  past.current_direction =
      to_current * (robust.judgement.translation_observable ? robust.judgement.pose.t : past.direction);
  const double seconds = result.pairs.seconds.value_or(kUsualInterval);
  if (!robust.judgement.pose_found || !(seconds > 0)) return;
  const RelativePose& pose = robust.judgement.pose;
  const double variance = pose.covariance.bottomRightCorner<3, 3>().trace();
  past.shutter.add({rotationVector(pose.R) / seconds, variance / (seconds * seconds)}, robust.judgement.row_rates,
                   robust.readout);
}

/// Notes which keypoints of the current image are static: those that the motion explains; without one, those that were.
/// Where a part of the view may be fixed to the camera, none is known to be.
void markStatic(const MatchResult& result, Past& past) {
  const RobustResult& robust = result.robust;
  past.reference_static.resize(static_cast<size_t>(result.keypoints_reference), 0);
  past.current_static.assign(static_cast<size_t>(result.keypoints_current), 0);
  const bool known = std::isnan(robust.judgement.evidence[Evidence::kFixedToCamera]);
  for (size_t row = 0; row < result.matches.size(); ++row) {
    const Match& match = result.matches[row];
    past.current_static[static_cast<size_t>(match.current)] =
        robust.judgement.probability.empty() ? past.isStatic(match.reference)
                                             : known && robust.judgement.probability[row] >= kLikelyStatic;
  }
}

}  // namespace

void Continuity::check(Method& method, const Camera& camera, MatchResult& result, const Past& past) {
  RobustResult& robust = result.robust;
  if (past.steady > 0 && robust.judgement.pose_found && !continues(robust, past)) {
    select(past, result);
    const RobustResult& alone = tracks_.robust;
    tracks_.clear();
    if (static_cast<int>(tracks_.rows.size()) >= kEnoughTracks) tracks_.estimate(method, camera, result);
    const bool confirmed =
        robust.judgement.translation_observable && isSame(alone.judgement.pose.t, robust.judgement.pose.t);
    if (alone.judgement.translation_observable && continues(alone, past) && !confirmed) tracks_.replace(camera, result);
  }
  if (robust.judgement.motion.t.dot(past.guess) < std::cos(kShown)) {
    robust.judgement.evidence[Evidence::kUnconfirmed] = robust.judgement.evidence[Evidence::kDirectionSigma];
  }
}

void Continuity::select(const Past& past, const MatchResult& result) {
  tracks_.rows.clear();
  for (size_t row = 0; row < result.matches.size(); ++row) {
    if (past.isStatic(result.matches[row].reference)) tracks_.rows.push_back(static_cast<int>(row));
  }
}

void continuePast(MatchResult& result, Past& past) {
  const RobustResult& robust = result.robust;
  markStatic(result, past);
  past.steady = robust.judgement.translation_observable ? kRemembered : std::max(0, past.steady - 1);
  remember(result, past);
  result.shutter = past.shutter.shutter();
}

}  // namespace gms_ransac
