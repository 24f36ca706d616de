// A pose at the optimum of its matches, with what was measured there: the first step of a judgement hands it to the
// second.
#pragma once

#include "judgement/match_noise.h"
#include "judgement/pose_covariance.h"
#include "judgement/segmentation.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

/// Keeps its storage.
struct RefinedPose {
  const ResidualKernels& kernels;
  const TwoViewPoints* points = nullptr;  ///< the matches; they outlive it
  TwoViewPose pose;
  TwoBodies bodies;        ///< if two share the matches, the pose is the motion of the larger one
  MatchNoise noise;        ///< at the pose
  PointColumns plausible;  ///< the points, those without weight that the noise calls implausible
  PoseInformation information;
  PoseCovariance covariance;
  PoseBreak worst_break;  ///< with RobustOptions::judge

  explicit RefinedPose(const ResidualKernels& residual_kernels) : kernels(residual_kernels), noise(residual_kernels) {}
  PoseModel model() const { return {kernels, points->view()}; }
  PoseModel plausibleModel() const { return {kernels, plausible.view()}; }
  /// Squared standard deviations of the noise in a squared threshold.
  float perVariance() const { return static_cast<float>(1 / noise.variance()); }
};

}  // namespace gms_ransac
