// A second rigid body that may be the world as well as the one whose motion the pose is.
#pragma once

#include <vector>

#include "judgement/match_noise.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// Share of the matches that the pose explains, which another motion must not reach among the others for the pose to be
/// the world's. Less where the matches contradict the camera model, as those of one body do by chance in one pair of a
/// hundred: the pose may then join two bodies. `contradiction`: CameraTest::statistic.
double mostOfSecondMotion(double contradiction);

class SecondMotion {
 public:
  explicit SecondMotion(const ResidualKernels& kernels) : kernels_(kernels) {}

  /// The matches that one other motion explains among those that the pose does not, as a share of those that it does; 0
  /// where they are too few to come to `least`.
  double share(const PointColumnsView& points, const MatchNoise& noise, double least);

 private:
  const ResidualKernels& kernels_;
  std::vector<int> rest_;  ///< columns that the pose does not explain
  PointColumns rest_points_;
  std::vector<TwoViewPose> motions_;
  std::vector<float> residuals_;
};

}  // namespace gms_ransac
