// Judges the motion of a pair, from any estimator, by its matches: noise, segmentation, covariance, the table of
// candidate motions, a verdict, probabilities. doc/inside/judgement.md has the formulas.
#pragma once

#include <vector>

#include "gms_ransac/robust_options.h"
#include "gms_ransac/robust_result.h"

#include "judgement/candidates.h"
#include "judgement/match_noise.h"
#include "judgement/pose_covariance.h"
#include "judgement/segmentation.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

/// Judges the pose of a pair in two steps, between which the estimator may reject it. Keeps its storage from pair to
/// pair.
class PoseJudge {
 public:
  explicit PoseJudge(const RobustOptions& options);

  /// Measures noise and covariance at a pose. `move`: first moves it from the optimum of the usual loss to that of a
  /// loss as wide as the noise of the matches, without the implausible ones. If two bodies share the matches, it moves
  /// to the motion of the larger one.
  void refine(const TwoViewPoints& points, bool move, TwoViewPose& pose);

  /// Judges the pose that was refined last, with the same points. `preferred`: the rotation that the estimator prefers
  /// for a reason other than the matches; it counts only where the matches leave the rotation open. Without
  /// RobustOptions::judge the preferred pose stands, with the covariance of the matches. Valid until the next call.
  const Judgement& judge(const TwoViewPoints& points, const TwoViewPose& preferred,
                         const std::vector<AlternativeMotion>& alternatives, bool shutter_may_roll);
  /// The same for a model that has no translation.
  const Judgement& judgeRotation(const TwoViewPoints& points, const Eigen::Matrix3d& R);

 private:
  /// Measures the noise at a pose.
  void measureNoise(const PointColumnsView& points, const TwoViewPose& pose);
  /// Noise and covariance at a pose or, with `move`, at the optimum of the loss that the noise asks for.
  void measure(const TwoViewPoints& points, bool move, TwoViewPose& pose);
  /// True if an optimum of the usual loss is also one of the loss that the noise asks for: their softness is equal, and
  /// no implausible match has a weight.
  bool atOptimum(int count) const;

  /// The first reason why the direction of translation is unknown, or kNone. `direction_sigma`: with the candidates
  /// that stand, radians.
  DirectionDoubt verdict(const TwoViewPoints& points, double direction_sigma);
  bool rotationIsKnown() const;
  bool directionIsKnown(double direction_sigma) const;
  /// True if plausible calibration errors could change the direction.
  bool cameraDecides() const;
  /// True if a second rigid body explains so many of the other matches that it may be the world as well.
  bool secondIsAsLarge(const PointColumnsView& points);

  /// Returns the pose with its rotation moved towards the preferred one, and the covariance widened by the step.
  RelativePose publish(const TwoViewPose& preferred, PoseSquare covariance) const;
  /// The pose of a rotation whose translation is a guess.
  RelativePose publishRotation(const Explanation& explanation) const;
  /// Fills all but the pose. `rotated`: matches are weighed by what the rotation leaves of them.
  const Judgement& conclude(const TwoViewPoints& points, DirectionDoubt doubt, bool rotated);

  const ResidualKernels& kernels_;
  RobustOptions options_;
  // Results of one step for the next, with their storage.
  TwoViewPose pose_;
  MatchNoise noise_;        ///< at the pose
  PointColumns plausible_;  ///< the points, those without weight that the noise calls implausible
  PoseInformation information_;
  PoseCovariance spread_;
  PoseBreak break_;  ///< at the pose; with RobustOptions::judge
  Segmentation segmentation_;
  Candidates candidates_;
  Judgement judgement_;
};

}  // namespace gms_ransac
