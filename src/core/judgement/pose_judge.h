// The room judgement decides how good an answer is and never looks for another one. A new kind of
// evidence is a number of Evidence, a row of probability.cpp, and a sentence in status_text.cpp.
//
// Judges the motion of a pair, from any estimator, by its matches: noise, segmentation, covariance, the table of
// candidate motions, a verdict, probabilities. doc/inside/judgement.md has the formulas.
#pragma once

#include <vector>

#include "gms_ransac/robust_options.h"
#include "gms_ransac/robust_result.h"
#include "judgement/candidates.h"
#include "judgement/refined_pose.h"
#include "judgement/segmentation.h"

namespace gms_ransac {

/// Judges the pose of a pair in two steps, between which the estimator may reject it. Holds nothing from pair to pair
/// but storage.
class PoseJudge {
 public:
  explicit PoseJudge(const RobustOptions& options);

  /// Measures noise and covariance at a pose. `move`: first moves it from the optimum of the usual loss to that of a
  /// loss as wide as the noise of the matches, without the implausible ones. If two bodies share the matches, it moves
  /// to the motion of the larger one. `points` outlive the result, which is valid until the next call.
  const RefinedPose& refine(const TwoViewPoints& points, bool move, const TwoViewPose& pose);

  /// Judges a pose. Without RobustOptions::judge it stands, with the covariance of the matches. Valid until the next
  /// call.
  const Judgement& judge(const RefinedPose& refined, const std::vector<AlternativeMotion>& alternatives,
                         bool shutter_may_roll);
  /// The same for a model that has no translation.
  const Judgement& judgeRotation(const TwoViewPoints& points, const Eigen::Matrix3d& R);

 private:
  /// Compares a pose with the candidates; empty without RobustOptions::judge.
  Verdict compare(const RefinedPose& refined, const std::vector<AlternativeMotion>& alternatives,
                  bool shutter_may_roll);
  EvidenceTable evidenceOf(const RefinedPose& refined, const Verdict& verdict);
  /// Takes the motion for right, or its rotation alone.
  void accept(bool with_translation);
  /// Fills all but poses and what is known of them. `rotated`: matches are weighed by what the rotation leaves of them.
  const Judgement& conclude(const RefinedPose& refined, bool rotated);

  RobustOptions options_;
  // Storage of what the steps hand on.
  RefinedPose refined_;
  Segmentation segmentation_;
  RotationAlone alone_;
  std::vector<float> residuals_;
  Judgement judgement_;
};

}  // namespace gms_ransac
