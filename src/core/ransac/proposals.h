// Motions that come from no sample: starts all over the sphere, another sensor's rotation, a plane's other motion.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "gms_ransac/relative_pose.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

constexpr size_t kMaxMotionStarts = 4;

/// Between images of a moving camera the rotation is small or follows from the matches alone. The direction of
/// translation is the problem: the cost has several local minima over the sphere, and a model from five noisy points
/// slides into one that is not the deepest. So each of 13 directions takes a few steps of optimisation on a random part
/// of the matches. It starts with the rotation that alone explains the matches best and, if that exceeds two degrees,
/// also with none. `starts` receives the best kMaxMotionStarts of different directions.
void findMotionStarts(const ResidualKernels& kernels, const PointColumnsView& points, std::vector<TwoViewPose>& starts);

/// Robust rotation that explains as much of the displacements as it can, from coarse to fine.
Eigen::Matrix3d fitDominantRotation(const PoseModel& model, const Eigen::Matrix3d& start);

/// With the prior's rotation two matches give a direction of translation. The direction with the most support is
/// refined together with the rotation: the prior is only where it starts.
TwoViewPose proposeFromRotation(const ResidualKernels& kernels, const PointColumnsView& points,
                                const RotationPrior& prior, PointColumns& storage);

/// The second motion that explains the displacements of a plane (Faugeras & Lustman 1988; closed form of Ma, Soatto,
/// Kosecka & Sastry 2004, section 5.3.3). None if most matches that `pose` explains lie on no plane, or if there is no
/// other motion. Fits the plane to the first slots, which are a random part.
std::optional<TwoViewPose> findOtherPlaneMotion(const PoseModel& model, const TwoViewPose& pose,
                                                std::vector<float>& storage);

}  // namespace gms_ransac
