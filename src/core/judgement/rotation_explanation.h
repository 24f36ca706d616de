// The matches explained by a camera that rotates and does not move: by a rotation alone, and by one that continues
// during the readout of a rolling shutter. Derived in doc/judgement.md.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "gms_ransac/robust_result.h"
#include "judgement/match_noise.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

struct RotationOnly {
  Eigen::Matrix3d R;             ///< from reference to current
  double median_parallax = 0;    ///< of the inliers, working units: the displacement that no rotation explains
  std::vector<float> residuals;  ///< squared transfer distance of each column
};

/// How far a pose explains the matches better than a rotation. Statistics of vuongStatistic on costs by the geometric
/// robust information criterion (Torr 1998).
struct RotationVerdict {
  double against_rotation = 0;   ///< the best rotation alone
  double against_rolling = 0;    ///< one with rolling shutter
  double static_share = 0;       ///< estimated share of the pose's inliers that the rotation leaves no parallax
  double share_at_infinity = 0;  ///< and of those that the pose's own rotation leaves none

  /// The reason against a translation: kRotationExplains, kMostlyStatic or kNone.
  DirectionDoubt doubt() const;
  /// True if a rotation explains the matches better than the pose, with rolling shutter or without.
  bool rotationIsBetter() const { return against_rotation < 0 || against_rolling < 0; }
  /// True if the camera is taken to have only rotated: what moves besides moves by itself.
  bool onlyRotated() const;
};

class RotationExplanation {
 public:
  /// Fits the best rotation alone. `noise`: measured at `start`.
  const RotationOnly& fit(const ResidualKernels& kernels, const PointColumnsView& points, const TwoViewPose& start,
                          const MatchNoise& noise);
  /// After that: its covariance, in the reference camera's frame.
  Eigen::Matrix3d covariance(const ResidualKernels& kernels, const PointColumnsView& points) const;
  /// And how it compares with a pose, which the noise was measured at.
  RotationVerdict compare(const TwoViewPoints& points, const TwoViewPose& pose, const MatchNoise& noise);

 private:
  /// The statistic against the rotation with rolling shutter that fits best, by reweighted least squares.
  double againstRolling(const TwoViewPoints& points, float inverse_variance);

  RotationOnly rotation_;
  std::vector<float> sorted_, pose_costs_, costs_;
  std::vector<double> by_cell_;
};

}  // namespace gms_ransac
