// Whether a different motion explains the matches as well as the one that was found.
#pragma once

#include <cstdint>
#include <vector>

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

/// True when a motion in another direction explains the matches as well as `pose`. Refines each of `alternatives`, on a
/// part of the matches first, and compares it with `pose` by the non-nested test of Vuong (Econometrica 1989) on the
/// truncated costs, each cell of the spread grid counted as one observation, because its matches err together.
/// `residuals`: of `pose`; `cells`: of each column; `rotation_spread`: angle in radians to the rotation of the
/// alternative, 0 without one.
bool findAlternativeMotion(const ResidualKernels& kernels, const PointColumnsView& points, const TwoViewPose& pose,
                           const std::vector<float>& residuals, const std::vector<AlternativeMotion>& alternatives,
                           const std::vector<int32_t>& cells, AlternativeBuffers& work, double& rotation_spread,
                           int64_t& evaluations);

}  // namespace gms_ransac
