// What the matches of a pair can tell of its motion, whichever estimator found it: parallax, other motions that explain
// them as well, uncertainty.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/robust_estimator.h"
#include "judgement/alternative_motion.h"
#include "judgement/pose_uncertainty.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// The direction of translation is taken as measured when the displacement that no rotation explains exceeds this many
/// pixels in the median. Below it the direction is off by 17 degrees in the median and 40 in the upper quarter on
/// real sequences (doc/estimator.md).
constexpr double kObservableParallaxPx = 1.5;

/// All matches of a pair on the normalised image plane, in an order unrelated to the image's, so that the first of them
/// are a random part.
struct JudgedMatches {
  PointColumnsView points;
  const std::vector<int32_t>* cells = nullptr;  ///< spreadCell of each column
  double unit_px = 1;                           ///< pixels per working unit
};

class PoseJudge {
 public:
  explicit PoseJudge(const ResidualKernels& kernels) : kernels_(&kernels) {}

  /// Fills all that `result` says of the pose. `optimum`: the pose at the optimum of the matches, which `others` are
  /// compared with; `pose`: the estimator's own, which stands where the pair shows a translation.
  void judge(const JudgedMatches& matches, const TwoViewPose& optimum, const TwoViewPose& pose,
             const std::vector<AlternativeMotion>& alternatives, RobustResult& result);
  /// The same without a verdict: the pose stands, with the covariance that the matches give it.
  void takeAsItIs(const JudgedMatches& matches, const TwoViewPose& optimum, const TwoViewPose& pose,
                  RobustResult& result);
  /// Likewise for a model that has no translation; `pose.t` is zero.
  void judgeRotation(const JudgedMatches& matches, const Eigen::Matrix3d& R, RobustResult& result);

 private:
  /// Fits the best rotation alone, with the parallax that it leaves those matches whose residuals_ are below 1.
  RotationOnly fitRotation(const JudgedMatches& matches, const TwoViewPose& start, RobustResult& result);
  /// Puts the rotation alone in place of the pose that `result` holds; its translation stays as the likeliest.
  static void settleForRotation(const RotationOnly& rotation, RobustResult& result);

  const ResidualKernels* kernels_;
  std::vector<float> residuals_, rotation_residuals_;
  AlternativeBuffers alternative_buffers_;
};

}  // namespace gms_ransac
