// Layout of the rendered scenes: rectangles in the world, z up, in metres.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "scenes/scene_texture.h"

namespace gms_ransac {

/// A textured rectangle, visible from the side its normal points to.
struct Surface {
  Eigen::Vector3d corner;  ///< where u = v = 0
  Eigen::Vector3d u, v;    ///< unit, along the sides
  Eigen::Vector3d normal;  ///< unit, towards the visible side
  double width, height;    ///< extent along u and v
  float shade;             ///< brightness factor by orientation
  TextureStyle style;
  Eigen::Vector3f tint;  ///< blue, green, red factors of the colour image
  double texel;          ///< metres per texture pixel
};

/// A hall of 13 x 13 x 3.6 m round the origin with furniture along the walls, in the middle and on the way;
/// free for a camera within 0.6 m of the circle of kRoomPathRadius.
std::vector<Surface> roomSurfaces(uint64_t seed);
constexpr double kRoomPathRadius = 3.6;

/// A street along x from 0 to kStreetLength, 11 m wide round y = 0, with vehicles, kiosks and poles at both sides;
/// free for a camera within 1.5 m of y = 0. Open to the sky.
std::vector<Surface> streetSurfaces(uint64_t seed);
constexpr double kStreetLength = 160;

}  // namespace gms_ransac
