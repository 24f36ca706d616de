// Layout of the rendered scenes, rectangles in the world, z up, in metres, and their procedural textures: grey images
// with corners at many scales, sampled with anti-aliasing.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace gms_ransac {

enum class TextureStyle { kBricks, kPlanks, kPictures, kShelves, kStones, kFacade, kCollage, kPlaster };

/// A texture with its mip levels (level l is 2^l times smaller).
class Texture {
 public:
  /// `width` x `height` metres with `texel` metres per texture pixel, painted when the first sample is taken; the same
  /// seed paints the same texture.
  Texture(TextureStyle style, double width, double height, double texel, uint64_t seed)
      : style_(style), width_(width), height_(height), texel_(texel), seed_(seed) {}

  /// Grey value (0..255) at (u, v) metres from the texture's first corner, averaged over about `footprint` metres:
  /// bilinear in each of the two nearest mip levels, linear between them.
  float sample(float u, float v, float footprint) const;

 private:
  void paint() const;

  const TextureStyle style_;
  const double width_, height_, texel_;  ///< metres
  const uint64_t seed_;
  mutable std::once_flag painted_;
  mutable std::vector<cv::Mat_<uint8_t>> levels_;
};

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

/// A hall with furniture that leaves 0.7 m round a path free. The path is centred on the z axis above the floor z = 0;
/// throws std::invalid_argument if it is longer than kLargestPath along x or y.
std::vector<Surface> hallSurfaces(uint64_t seed, const std::vector<Eigen::Vector3d>& path);
constexpr double kLargestPath = 100;

/// A street along x from 0 to kStreetLength, 11 m wide round y = 0, with vehicles, kiosks and poles at both sides;
/// free for a camera within 1.5 m of y = 0. Open to the sky.
std::vector<Surface> streetSurfaces(uint64_t seed);
constexpr double kStreetLength = 160;

}  // namespace gms_ransac
