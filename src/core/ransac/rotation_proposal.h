// The motion that another sensor's rotation and the matches say together: a proposal for the loop.
#pragma once

#include <cstdint>

#include "gms_ransac/rotation_prior.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// With the rotation known the epipolar constraint is linear in t, and two matches give a direction. Of some drawn
/// without chance the one that most matches support is taken, then both are moved to the optimum near them: the
/// rotation, too, since the prior's has noise. Nothing of the prior but the place where it starts is in the result.
class RotationProposal {
 public:
  TwoViewPose find(const ResidualKernels& kernels, const PointColumnsView& points, const RotationPrior& prior,
                   int64_t& evaluations);

 private:
  /// The first columns, each with the threshold that the prior's noise leaves it.
  PointColumnsView widen(const PointColumnsView& points, const RotationPrior& prior);

  PointColumns widened_;  ///< storage
};

}  // namespace gms_ransac
