// Procedural textures for the rendered scene: grey images with corners at many scales, sampled with anti-aliasing.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

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

}  // namespace gms_ransac
