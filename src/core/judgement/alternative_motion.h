// Whether a different motion explains the matches as well as the one that was found.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "judgement/judged_pose.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// A motion that came into question beside the best one.
struct AlternativeMotion {
  TwoViewPose pose;
  bool of_plane = false;  ///< explains a plane just as well, so that chance decides which of the two fits better
};

constexpr double kOtherDirection = 20 * M_PI / 180;

/// What the alternatives that explain the matches as well leave open.
struct Ambiguity {
  bool other_direction = false;  ///< one of them has t more than kOtherDirection away
  /// Covariance to be added to that of the pose, in the parameters of PoseModel::linearize: any of them may be true.
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
};

class AlternativeMotions {
 public:
  explicit AlternativeMotions(const ResidualKernels& kernels) : kernels_(kernels) {}

  /// Refines each of `alternatives` as the pose was, on a part of the matches first, and compares it with the pose by
  /// the non-nested test of Vuong (Econometrica 1989) on the truncated costs, each cell of the spread grid counted as
  /// one observation, because its matches err together. `plausible`: the points with the implausible ones weighing
  /// nothing, which have no part in either.
  Ambiguity compare(const JudgedPose& judged, const PointColumnsView& plausible,
                    const std::vector<AlternativeMotion>& alternatives, int64_t& evaluations);

 private:
  /// What each of them is compared with, and on.
  struct Comparison {
    const JudgedPose& judged;
    PointColumnsView plausible;
    double same_within;  ///< directions of translation that are closer, radians, are one minimum of the cost
    int64_t& evaluations;

    double apart(const TwoViewPose& motion) const;
    bool isSame(const TwoViewPose& motion) const { return apart(motion) < same_within; }
  };

  /// Whether a motion, once it is refined, explains the matches as well as the pose does. `least`: Vuong's statistic
  /// from which on the pose is better.
  bool explainsAsWell(const Comparison& comparison, double least, TwoViewPose& motion);
  /// Refines a motion on the first `count` matches; whether it is still another one, and the statistic there less.
  bool isNoWorse(const Comparison& comparison, int count, int iterations, double least, TwoViewPose& motion);
  /// Vuong's statistic for the pose against the motion whose residuals_ are those of the first `count` matches.
  double vuong(const JudgedPose& judged, int count);

  const ResidualKernels& kernels_;
  std::vector<float> residuals_;
  std::vector<double> by_cell_;
};

}  // namespace gms_ransac
