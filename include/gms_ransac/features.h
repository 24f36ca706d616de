// The features of one image: keypoints and their descriptors.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/simd.h"

namespace gms_ransac {

constexpr int kDescriptorBytes = 32;  ///< of ORB, which the fast kernels compare

/// Vector loads that cross one take twice as long.
struct alignas(64) CacheLine {
  uint8_t bytes[64];
};

/// N descriptors of one kind. Those of 32 bytes are row-major, with a transposed copy for the vector kernels; their
/// storage only grows. Binary ones of another length and floating-point ones are a matrix.
class DescriptorSet {
 public:
  /// Room for `n` descriptors of 32 bytes.
  void resize(int n);
  int size() const { return size_; }
  /// True for descriptors of 32 bytes. Only these have `row`, `pack` and `packed`.
  bool is256Bit() const { return other_.empty(); }
  /// True if distances between the two sets are defined: one kind and one length, or one of them is empty.
  bool comparableWith(const DescriptorSet& other) const;
  /// "32 bytes" or "128 floats".
  std::string kind() const;
  uint8_t* row(int i) { return rows_.data() + static_cast<size_t>(i) * kDescriptorBytes; }
  const uint8_t* row(int i) const { return rows_.data() + static_cast<size_t>(i) * kDescriptorBytes; }
  /// View, valid until the next change: N x K CV_8U, or N x D CV_32F.
  cv::Mat asMat() const;
  /// Copies N x K bytes (CV_8U, binary descriptors) or N x D floats (CV_32F), and packs those of 32 bytes. Throws
  /// std::invalid_argument for another type and for a float that is not finite.
  void assign(const cv::Mat& rows);

  /// Builds the layout that the kernel of `level` reads.
  void pack(SimdLevel level = detectSimdLevel());
  bool packedFor(SimdLevel level) const { return is_packed_ && packed_level_ == level; }
  const uint8_t* packed() const { return packed_.empty() ? nullptr : packed_.front().bytes; }

 private:
  int size_ = 0;
  cv::Mat other_;  ///< what is not of 32 bytes; empty: none is
  std::vector<uint8_t> rows_;
  std::vector<CacheLine> packed_;
  bool is_packed_ = false;
  SimdLevel packed_level_ = SimdLevel::kScalar;
};

/// True for a coordinate of an image with so many pixels to the side, which reach half a pixel beyond their centres;
/// false for NaN.
inline bool isInImage(float coordinate, int side) {
  return coordinate >= -0.5f && coordinate <= static_cast<float>(side) - 0.5f;
}

/// Degrees in 0..360 of an angle in -360..360; exactly -1, which is OpenCV's for an unknown one, stays.
inline float wrappedAngle(float degrees) { return degrees < 0 && degrees != -1 ? degrees + 360 : degrees; }
/// False for NaN.
inline bool isAngle(float degrees) { return degrees >= -360 && degrees <= 360; }

/// Keypoints and descriptors of one image. Row i of `descriptors` belongs to `keypoints[i]`.
struct Features {
  static constexpr int kOctaves = 16;         ///< pyramid levels that there can be
  static constexpr int kLargestSide = 32768;  ///< pixels of an image; an int holds the area

  cv::Size image_size;        ///< pixels of the received image
  float scale_factor = 1.2f;  ///< between pyramid levels; a keypoint of octave l has noise scale_factor^l px
  /// pt: pixels of the received image; octave: pyramid level, 0 if there is none; angle: degrees 0..360 or
  /// -180..180, exactly -1 if unknown
  std::vector<cv::KeyPoint> keypoints;
  DescriptorSet descriptors;  ///< packed for matching by the extractor

  int size() const { return static_cast<int>(keypoints.size()); }
  /// For features that the caller filled. Throws std::invalid_argument with a sentence that names what is wrong:
  /// another number of descriptors than of keypoints, or the first keypoint outside the image or with an impossible
  /// octave or angle. (cv::SIFT packs octave and layer into one number.)
  void validate() const;
};

}  // namespace gms_ransac
