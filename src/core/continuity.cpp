#include "continuity.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "judgement/candidates.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

namespace {

/// Fewer tracks seldom show a motion.
constexpr size_t kEnoughTracks = 30;
/// So many pairs in one direction let the next one be expected; it is waited for over as many pairs as were steady.
constexpr int kSteady = 2, kMostSteady = 4;
/// In a hand one in ten pairs whose direction nothing before shows is wrong, most with near and far exchanged. If the
/// pair before shows it, be it as a guess, one in sixty is. Certain to half the limit, the others are as good.
constexpr double kShown = 30 * M_PI / 180, kShareOfLimit = 0.5;
constexpr float kMostDeviations = 3;  ///< of a static point
constexpr float kNotJudged = 0.5f;    ///< probability of a match that the motion explains and that no track vouches for

bool isSame(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.dot(b) > std::cos(kOtherDirection); }

/// Standard deviation along the widest axis, radians.
double directionSigma(const RelativePose& pose) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(Eigen::Matrix3d(pose.covariance.topLeftCorner<3, 3>()),
                                                            Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues().z()));
}

/// Another rotation may be the right one: the covariance of this one gets the square of the step to it.
void widen(const Eigen::Matrix3d& other, RelativePose& pose) {
  const Eigen::Vector3d step = rotationVector(other * pose.R.transpose());
  pose.covariance.bottomRightCorner<3, 3>() += step * step.transpose();
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
  if (!robust.judgement.pose_found) return;
  const Eigen::Vector3d turned = rotationVector(to_current);
  past.shutter.add({turned.x(), turned.y(), turned.z()}, result.pairs.seconds, robust.judgement.row_rates);
}

/// Notes which keypoints of the current image are static: those that the motion explains; without one, those that were.
void label(const MatchResult& result, Past& past) {
  const RobustResult& robust = result.robust;
  past.reference_static.resize(static_cast<size_t>(result.keypoints_reference), 0);
  past.current_static.assign(static_cast<size_t>(result.keypoints_current), 0);
  for (size_t k = 0; k < result.matches.size(); ++k) {
    const Match& match = result.matches[k];
    past.current_static[static_cast<size_t>(match.current)] = robust.judgement.probability.empty()
                                                                  ? past.isStatic(match.reference)
                                                                  : robust.judgement.probability[k] >= kNotJudged;
  }
}

}  // namespace

void Continuity::follow(Method& method, const Camera& camera, const RobustOptions& options, MatchResult& result,
                        Past& past) {
  const bool judge = options.judge;
  RobustResult& robust = result.robust;
  const auto continues = [&past](const RobustResult& answer) {
    return past.steady > 0 && isSame(answer.judgement.pose.t, past.direction);
  };
  const bool known = robust.judgement.translation_observable;
  if (judge && robust.judgement.pose_found && (known || past.steady > 0) && !continues(robust)) {
    select(past, result);
    alone_.clear();
    if (tracks_.size() >= kEnoughTracks) method.estimate(pairs_, camera, alone_);
    robust.effort += alone_.effort;
    if (!known) {
      if (alone_.judgement.translation_observable && continues(alone_)) take(camera, result);
    } else if (!alone_.judgement.pose_found) {
      if (past.steady >= kSteady) robust.reject();
      if (!robust.judgement.pose_found) robust.judgement.doubt = DirectionDoubt::kDiscontinuity;
    } else if (!isSame(alone_.judgement.pose.t, robust.judgement.pose.t)) {
      if (!alone_.judgement.translation_observable || !continues(alone_)) {
        alone_.judgement.refuse(DirectionDoubt::kDiscontinuity);
        widen(robust.judgement.pose.R, alone_.judgement.pose);
      }
      take(camera, result);
    }
  }
  const double limit = kShareOfLimit * options.max_direction_sigma * M_PI / 180;
  if (judge && robust.judgement.translation_observable && robust.judgement.pose.t.dot(past.guess) < std::cos(kShown) &&
      directionSigma(robust.judgement.pose) > limit) {
    robust.judgement.refuse(DirectionDoubt::kUnconfirmed);
  }
  label(result, past);
  if (!robust.judgement.translation_observable) {
    past.steady = std::max(0, past.steady - 1);
  } else {
    past.steady = continues(robust) ? std::min(past.steady + 1, kMostSteady) : 1;
  }
  remember(result, past);
}

void Continuity::select(const Past& past, const MatchResult& result) {
  tracks_.clear();
  for (size_t k = 0; k < result.matches.size(); ++k) {
    if (past.isStatic(result.matches[k].reference)) tracks_.push_back(static_cast<int>(k));
  }
  pairs_.gather(result.pairs, tracks_);
}

void Continuity::take(const Camera& camera, MatchResult& result) {
  RobustResult& robust = result.robust;
  const PointPairs& all = result.pairs;
  const auto count = static_cast<size_t>(all.size());
  // A match that continues no static track is no inlier. One that the motion explains may be static, to the next pair.
  inlier_.assign(count, 0);
  probability_.assign(count, 0);
  residual_.resize(count);
  const bool moves = alone_.judgement.translation_observable;
  const Eigen::Matrix3d K = camera.K();
  const Eigen::Matrix3d rotation = K * alone_.judgement.pose.R.transpose() * K.inverse();
  const FinalResidual residuals(camera, moves ? alone_.model_type : ModelType::kHomography,
                                moves ? alone_.model : rotation);
  residuals.forEach(all, [&](size_t i, double squared) {
    // A transfer distance has the noise of both images.
    const double sigma = alone_.judgement.sigma(all.octave_current[i], all.scale_factor) * (moves ? 1 : M_SQRT2);
    residual_[i] = static_cast<float>(std::sqrt(squared) / sigma);
    if (residual_[i] < kMostDeviations) probability_[i] = kNotJudged;
  });
  for (size_t n = 0; n < tracks_.size(); ++n) {
    const auto k = static_cast<size_t>(tracks_[n]);
    inlier_[k] = alone_.inlier[n];
    probability_[k] = alone_.judgement.probability[n];
    residual_[k] = alone_.judgement.residual[n];
  }
  alone_.effort = robust.effort;
  alone_.inlier.swap(inlier_);
  alone_.judgement.probability.swap(probability_);
  alone_.judgement.residual.swap(residual_);
  std::swap(robust, alone_);
}

}  // namespace gms_ransac
