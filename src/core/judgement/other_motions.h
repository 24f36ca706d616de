// Tests if an alternative motion explains the matches as well as the pose.
#pragma once

#include <cmath>
#include <vector>

#include "judgement/match_noise.h"
#include "judgement/pose_covariance.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

/// Directions of translation that differ by more, radians, are two motions.
constexpr double kOtherDirection = 20 * M_PI / 180;

/// A motion that came into question besides the best one.
struct AlternativeMotion {
  TwoViewPose pose;
  bool of_plane = false;  ///< explains a plane just as well, so that chance decides which of the two fits better
};

/// A refined pose with what is known of it.
struct RefinedPose {
  TwoViewPose pose;
  const TwoViewPoints& points;
  PointColumnsView plausible;  ///< the points, those without weight that the noise calls implausible
  const MatchNoise& noise;     ///< at the pose
};

/// The uncertainty from alternatives that explain the matches as well.
struct Ambiguity {
  bool other_direction = false;  ///< one of them has a direction more than kOtherDirection away
  /// To be added to the covariance of the pose: any of them may be true.
  PoseSquare covariance = PoseSquare::Zero();
};

class OtherMotions {
 public:
  explicit OtherMotions(const ResidualKernels& kernels) : kernels_(kernels) {}

  /// Refines each of `alternatives` as the pose was, on a part of the matches first, and compares it with the pose by
  /// vuongStatistic on the truncated costs. `direction_sigma`: of the pose, radians; `camera_decides`: true if
  /// plausible calibration errors could change the direction, and so whether near and far are exchanged.
  Ambiguity compare(const RefinedPose& refined, double direction_sigma, bool camera_decides,
                    const std::vector<AlternativeMotion>& alternatives);
  /// The matches that one other motion explains among those that the pose does not, as a share of those that it does; 0
  /// where they are too few to come to `least`. A second rigid body of that share may be the world as well.
  double shareOfSecond(const PointColumnsView& points, const MatchNoise& noise, double least);

 private:
  /// Refines a motion on the first `count` matches and returns Vuong's statistic there for the pose against it;
  /// infinite if it converged to the pose: their directions then agree to `same_within` radians.
  double against(const RefinedPose& refined, double same_within, int count, int iterations, TwoViewPose& motion);

  const ResidualKernels& kernels_;
  std::vector<float> residuals_;
  std::vector<double> by_cell_;
  std::vector<int> rest_;  ///< columns that the pose does not explain
  PointColumns rest_points_;
  std::vector<TwoViewPose> motions_;
};

}  // namespace gms_ransac
