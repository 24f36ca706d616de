// The views of a plane have two explanations; here is the other one.
#pragma once

#include <optional>
#include <vector>

#include "two_view/pose_model.h"

namespace gms_ransac {

/// The second motion that explains the displacements of a plane (Faugeras & Lustman 1988; closed form of Ma, Soatto,
/// Kosecka & Sastry 2004, section 5.3.3). None if most matches that `pose` explains lie on no plane, or if there is no
/// other motion. Fits the plane to the first columns, which are a random part.
std::optional<TwoViewPose> findOtherPlaneMotion(const PoseModel& model, const TwoViewPose& pose,
                                                std::vector<float>& storage);

}  // namespace gms_ransac
