// Judges the motion of a pair, from any estimator, by its matches: noise, segmentation, covariance, alternative
// motions, probabilities. doc/judgement.md has the formulas.
#pragma once

#include <vector>

#include "gms_ransac/robust_options.h"
#include "gms_ransac/robust_result.h"
#include "judgement/match_noise.h"
#include "judgement/match_probability.h"
#include "judgement/other_motions.h"
#include "judgement/pose_covariance.h"
#include "judgement/pose_information.h"
#include "judgement/rotation_explanation.h"
#include "judgement/second_motion.h"
#include "judgement/segmentation.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

/// Judges the pose of a pair in two steps, between which the estimator may reject it. Keeps its storage from pair to
/// pair.
class PoseJudge {
 public:
  explicit PoseJudge(const RobustOptions& options);

  /// Takes a pose at the optimum of the usual loss to the optimum of a loss as wide as the noise of the matches,
  /// without the implausible ones. Where two bodies share the matches, takes it to the motion of the larger one.
  /// `points` have to outlive the next step.
  void refine(const TwoViewPoints& points, TwoViewPose& pose);
  /// The same for a pose that has to stay.
  void take(const TwoViewPoints& points, const TwoViewPose& pose);

  /// Fills `result` for the pose that was refined or taken last. `preferred`: the rotation that the estimator prefers
  /// for a reason other than the matches; it counts only where the matches leave the rotation open. Without
  /// RobustOptions::judge the preferred pose stands, with the covariance of the matches.
  void judge(const TwoViewPose& preferred, const std::vector<AlternativeMotion>& alternatives, RobustResult& result);
  /// The same for a model that has no translation.
  void judgeRotation(const TwoViewPoints& points, const Eigen::Matrix3d& R, RobustResult& result);

 private:
  RefinedPose refined() const { return {pose_, *points_, plausible_.view(), noise_}; }
  /// Measures the noise at a pose.
  void measureNoise(const TwoViewPose& pose);
  /// Moves the pose to the optimum of the loss that the noise asks for.
  void followNoise(TwoViewPose& pose);
  /// Sums the information of the matches on the pose, and computes the covariance.
  void measureCovariance();
  /// Returns the first reason why the direction of translation is unknown, or kNone. Widens the covariance by
  /// alternative motions that explain the matches as well.
  DirectionDoubt compare(const RotationVerdict& verdict, const std::vector<AlternativeMotion>& alternatives,
                         PoseSquare& covariance);
  bool rotationIsKnown() const;
  bool directionIsKnown(double direction_sigma) const;
  /// Returns the pose with its rotation moved towards the preferred one, and the covariance widened by the step.
  RelativePose publish(const TwoViewPose& preferred, PoseSquare covariance) const;
  /// Fills noise and probabilities; by what a rotation leaves of the matches where that is given.
  void weighMatches(const std::vector<float>* rotation_residuals, RobustResult& result);

  const ResidualKernels& kernels_;
  RobustOptions options_;
  // Results of one step for the next.
  const TwoViewPoints* points_ = nullptr;
  TwoViewPose pose_;
  MatchNoise noise_;        ///< at the pose
  PointColumns plausible_;  ///< the points, those without weight that the noise calls implausible
  Segmentation segmentation_;
  PoseCovariance spread_;
  // The steps, with their storage.
  PoseSummation summation_;
  Segmenter segmenter_;
  RotationExplanation rotation_explanation_;
  OtherMotions other_motions_;
  SecondMotion second_motion_;
  MatchProbability probability_;
};

}  // namespace gms_ransac
