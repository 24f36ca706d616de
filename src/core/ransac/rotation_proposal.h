// A proposal for the loop from another sensor's rotation and the matches.
#pragma once

#include "gms_ransac/relative_pose.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// With the rotation known two matches give a direction of translation. The direction with the most support is refined
/// together with the rotation: the prior is only where it starts.
class RotationProposal {
 public:
  TwoViewPose find(const ResidualKernels& kernels, const PointColumnsView& points, const RotationPrior& prior);

 private:
  /// The first columns, each with the threshold that the prior's noise leaves it.
  PointColumnsView widen(const PointColumnsView& points, const RotationPrior& prior);

  PointColumns widened_;  ///< storage
};

}  // namespace gms_ransac
