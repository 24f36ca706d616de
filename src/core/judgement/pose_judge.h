// What the matches of a pair can tell of its motion, whichever estimator found it: noise, uncertainty, parallax, other
// motions that explain them as well.
#pragma once

#include <vector>

#include "gms_ransac/robust_estimator.h"
#include "judgement/alternative_motion.h"
#include "judgement/body_parting.h"
#include "judgement/judged_pose.h"
#include "judgement/match_noise.h"
#include "judgement/match_probability.h"
#include "judgement/pose_uncertainty.h"
#include "judgement/rotation_only.h"
#include "judgement/rotation_rivals.h"
#include "judgement/second_body.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

class PoseJudge {
 public:
  explicit PoseJudge(const RobustOptions& options)
      : kernels_(residualKernels(options.simd)),
        options_(options),
        bodies_(kernels_),
        other_motions_(kernels_),
        second_body_(kernels_) {}

  /// Takes up a pair: its matches on the normalised image plane, which must outlive what follows.
  void begin(const TwoViewPoints& points);

  /// Moves a pose at the optimum of the usual loss to that of one as wide as the noise, without the matches that are
  /// implausible however near their epipolar line they lie. Where one part of the view contradicts the rest, to that of
  /// the larger of two bodies.
  void refine(TwoViewPose& pose, Effort& effort);

  /// Fills all that `result` says of the pose. `optimum`: the pose at the optimum of the matches, which `alternatives`
  /// are compared with; `preferred`: the rotation that the estimator would rather have, where it has a reason beside
  /// the matches. It is followed as far as the matches leave it open.
  void judge(const TwoViewPose& optimum, const TwoViewPose& preferred,
             const std::vector<AlternativeMotion>& alternatives, RobustResult& result);
  /// The same without a verdict: the preferred pose stands, with the covariance that the matches give it.
  void takeAsItIs(const TwoViewPose& optimum, const TwoViewPose& preferred, RobustResult& result);
  /// Likewise for a model that has no translation; `pose.t` is zero.
  void judgeRotation(const Eigen::Matrix3d& R, RobustResult& result);

 private:
  void measureNoise(const TwoViewPose& pose, Effort& effort);
  /// To the optimum of the loss that the noise asks for.
  void followNoise(TwoViewPose& pose, Effort& effort);
  /// Where one part of the view contradicts the rest and two motions explain both: to that of the larger part.
  void followLargerBody(TwoViewPose& pose, Effort& effort);
  /// At the pose that the noise was measured at last.
  const PoseSpread& measuredSpread();
  JudgedPose judged() { return {measured_at_, *points_, noise_, measuredSpread()}; }
  /// Whether a loss with that cut gives weight to an implausible match.
  bool weighsImplausible(float cut) const;
  /// Fills plausible_ with the matches, the implausible ones without weight.
  void keepPlausible();
  /// Fits the best rotation alone, with the parallax that it leaves the inliers.
  RotationOnly fitRotation(const TwoViewPose& start, RobustResult& result);
  /// Puts the pose between `optimum` and `preferred` into the result, with its covariance.
  void settle(const TwoViewPose& optimum, const TwoViewPose& preferred, PoseSpread& spread, RobustResult& result) const;
  PoseSpread describeSpread(RobustResult& result);
  /// The first four questions of doc/uncertainty.md, "Status"; the fifth is that of other motions.
  DirectionDoubt doubtOf(const RotationVerdict& verdict, const PoseSpread& spread) const;
  static bool knowsRotation(const PoseSpread& spread);
  /// Whether the direction of translation is as well known as the user wants it.
  bool closeEnough(const PoseSpread& spread) const;
  /// Widens the covariance to hold the other motions that explain the matches as well; whether one of them has another
  /// direction.
  bool takeInAlternatives(const std::vector<AlternativeMotion>& alternatives, PoseSpread& spread, Effort& effort);
  /// `turned`: by the rotation that fitRotation found, instead of by the pose.
  void describeMatches(bool turned, RobustResult& result);

  const ResidualKernels& kernels_;
  RobustOptions options_;
  const TwoViewPoints* points_ = nullptr;
  PointColumnsView view_ = {};
  MatchNoise noise_;
  bool measured_ = false;
  TwoViewPose measured_at_;
  bool spread_known_ = false;  ///< at measured_at_
  PoseSpread spread_;
  BodyParting bodies_;
  MatchProbability probability_;
  PoseUncertainty uncertainty_;
  RotationRivals rivals_;
  PointColumns plausible_;
  std::vector<float> rotation_residuals_, sorted_;
  AlternativeMotions other_motions_;
  SecondBody second_body_;
};

}  // namespace gms_ransac
