// Starting points for the pose that need no samples: optimisation from directions of translation all over the sphere.
#pragma once

#include <cstddef>
#include <vector>

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

}  // namespace gms_ransac
