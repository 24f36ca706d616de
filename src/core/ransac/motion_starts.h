// Starting points for the pose that need no samples: optimisation from directions of translation all over the sphere.
#pragma once

#include <cstdint>
#include <vector>

#include "two_view/pose_model.h"

namespace gms_ransac {

constexpr int kMaxMotionStarts = 4;

/// Between images of a moving camera the rotation is small or can be had from the matches alone, and what goes wrong is
/// the direction of translation: the cost has several local minima over the sphere, and a model from five noisy points
/// slides into one that is not the deepest. So a few steps of optimisation are taken on a random part of the matches
/// from each of 13 directions, with the rotation that alone explains the matches best and, where that is more than two
/// degrees, with none; the best kMaxMotionStarts of different directions are left in `starts`.
void findMotionStarts(const ResidualKernels& kernels, const PointColumnsView& points, std::vector<TwoViewPose>& starts,
                      int64_t& evaluations);

/// Robust rotation that explains as much of the displacements as it can, from coarse to fine.
Eigen::Matrix3d fitDominantRotation(const PoseModel& model, const PointColumnsView& points,
                                    const Eigen::Matrix3d& start, int64_t& evaluations);

}  // namespace gms_ransac
