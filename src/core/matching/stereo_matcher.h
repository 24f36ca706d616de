// Features of two cameras at one moment -> pairs that lie on one row of the rectified images.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/features.h"

namespace gms_ransac {

struct StereoMatch {
  int32_t left, right;  ///< indices into the features
  uint16_t distance;    ///< Hamming
};

/// Rays of keypoints on the plane z = 1 of the rectified camera; NaN: no ray.
using RectifiedRays = std::vector<Eigen::Vector2d>;

constexpr double kUsualRowTolerance = 1.5;  ///< pixels

/// Mutual nearest descriptors on one row, on neighbouring octaves, nearer than infinity and at most a quarter of the
/// image's width apart, in the order of the left keypoints. `focal_length`: pixels, of both cameras. `row_tolerance`:
/// pixels, of the rows of two keypoints of octave 0; grows with the octave like their noise.
void matchRows(const Features& left, const RectifiedRays& left_rays, const Features& right,
               const RectifiedRays& right_rays, double focal_length, double row_tolerance,
               std::vector<StereoMatch>& matches);

}  // namespace gms_ransac
