// The features of one image: keypoints and their 256-bit binary descriptors.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/simd.h"

namespace gms_ransac {

constexpr int kDescriptorBytes = 32;

/// Vector loads that cross one take twice as long.
struct alignas(64) CacheLine {
  uint8_t bytes[64];
};

/// N descriptors of 32 bytes, row-major, and a transposed copy for the vector kernels. Storage only grows.
class DescriptorSet {
 public:
  void resize(int n);
  int size() const { return size_; }
  uint8_t* row(int i) { return rows_.data() + static_cast<size_t>(i) * kDescriptorBytes; }
  const uint8_t* row(int i) const { return rows_.data() + static_cast<size_t>(i) * kDescriptorBytes; }
  /// N x 32 CV_8U view; valid until the next resize.
  cv::Mat asMat() const;
  /// Copies and packs an N x 32 CV_8U matrix. Throws std::invalid_argument for another type or width.
  void assign(const cv::Mat& rows);

  /// Builds the layout that the kernel of `level` reads.
  void pack(SimdLevel level = detectSimdLevel());
  bool packedFor(SimdLevel level) const { return is_packed_ && packed_level_ == level; }
  const uint8_t* packed() const { return packed_.empty() ? nullptr : packed_.front().bytes; }

 private:
  int size_ = 0;
  std::vector<uint8_t> rows_;
  std::vector<CacheLine> packed_;
  bool is_packed_ = false;
  SimdLevel packed_level_ = SimdLevel::kScalar;
};

/// Keypoints and descriptors of one image. Row i of `descriptors` belongs to `keypoints[i]`.
struct Features {
  cv::Size image_size;                  ///< pixels of the received image
  float scale_factor = 1.2f;            ///< between pyramid levels; a keypoint of octave l has noise scale_factor^l px
  std::vector<cv::KeyPoint> keypoints;  ///< pt: pixels of the received image; octave: pyramid level; angle: degrees
  DescriptorSet descriptors;            ///< packed for matching by the extractor

  int size() const { return static_cast<int>(keypoints.size()); }
};

}  // namespace gms_ransac
