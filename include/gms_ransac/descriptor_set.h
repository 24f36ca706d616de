// 256-bit binary descriptors of one image, in the layouts the matcher reads.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/simd.h"

namespace gms_ransac {

constexpr int kDescriptorBytes = 32;

/// N descriptors of 32 bytes, row-major, and a transposed copy for the matcher's vector kernels.
/// Storage only grows, so a set that is refilled every frame stops allocating.
class DescriptorSet {
 public:
  /// Makes room for n rows; contents of the rows are unspecified afterwards and the set is not packed.
  void resize(int n);
  int size() const { return size_; }
  uint8_t* row(int i) { return rows_.data() + static_cast<size_t>(i) * kDescriptorBytes; }
  const uint8_t* row(int i) const { return rows_.data() + static_cast<size_t>(i) * kDescriptorBytes; }
  /// N x 32 CV_8U view of the rows; valid until the next resize.
  cv::Mat asMat() const;
  /// Copies the rows of an N x 32 CV_8U matrix and packs them. Throws std::invalid_argument for another type or width.
  void assign(const cv::Mat& rows);

  /// Builds the transposed layout that the kernel of `level` reads; call once after the rows are written.
  void pack(SimdLevel level = detectSimdLevel());
  /// True when `pack(level)` came after the last resize.
  bool packedFor(SimdLevel level) const { return is_packed_ && packed_level_ == level; }
  const uint8_t* packed() const { return packed_.empty() ? nullptr : packed_.front().bytes; }

 private:
  /// Vector loads that cross a cache line take twice as long.
  struct alignas(64) CacheLine {
    uint8_t bytes[64];
  };

  int size_ = 0;
  std::vector<uint8_t> rows_;
  std::vector<CacheLine> packed_;
  bool is_packed_ = false;
  SimdLevel packed_level_ = SimdLevel::kScalar;
};

}  // namespace gms_ransac
