// Whether a different motion explains the matches as well as the one that was found.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "judgement/match_noise.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// A motion that came into question beside the best one.
struct AlternativeMotion {
  TwoViewPose pose;
  bool of_plane = false;  ///< explains a plane just as well, so that chance decides which of the two fits better
};

/// Kept from pair to pair, so that nothing is allocated; residuals with room for all columns.
struct AlternativeBuffers {
  std::vector<float> residuals;
  std::vector<double> by_cell;
};

constexpr double kOtherDirection = 20 * M_PI / 180;

/// What the alternatives that explain the matches as well leave open.
struct Ambiguity {
  bool other_direction = false;  ///< one of them has t more than kOtherDirection away
  /// Covariance to be added to that of the pose, in the parameters of PoseModel::linearize: any of them may be true.
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
};

/// Refines each of `alternatives` as `pose` was, on a part of the matches first, and compares it with `pose` by the
/// non-nested test of Vuong (Econometrica 1989) on the truncated costs, each cell of the spread grid counted as one
/// observation, because its matches err together. `plausible`: `points` with the implausible ones of `noise` weighing
/// nothing, which have no part in either; `noise`: measured at `pose`; `cells`: of each column; `same_within`:
/// directions of translation that are closer, in radians, are the same local minimum of the cost.
Ambiguity findAlternativeMotion(const ResidualKernels& kernels, const PointColumnsView& points,
                                const PointColumnsView& plausible, const TwoViewPose& pose, const MatchNoise& noise,
                                const std::vector<AlternativeMotion>& alternatives, const std::vector<int32_t>& cells,
                                double same_within, AlternativeBuffers& work, int64_t& evaluations);

}  // namespace gms_ransac
