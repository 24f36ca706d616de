// 256-bit binary descriptors of one image, in the layouts the matcher reads.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

namespace gms_ransac {

constexpr int kDescriptorBytes = 32;

/// N descriptors of 32 bytes, row-major. Storage only grows, so a set that is refilled every frame stops allocating.
class DescriptorSet {
 public:
  /// Makes room for n rows; contents of the rows are unspecified afterwards.
  void resize(int n);
  int size() const { return size_; }
  uint8_t* row(int i) { return rows_.data() + static_cast<size_t>(i) * kDescriptorBytes; }
  const uint8_t* row(int i) const { return rows_.data() + static_cast<size_t>(i) * kDescriptorBytes; }
  /// N x 32 CV_8U view of the rows; valid until the next resize.
  cv::Mat asMat() const;
  /// Copies the rows of an N x 32 CV_8U matrix and packs them. Throws std::invalid_argument for another type or width.
  void assign(const cv::Mat& rows);
  /// Builds the transposed layout; call once after the rows are written, before the set is used as `current`.
  void pack();

 private:
  int size_ = 0;
  std::vector<uint8_t> rows_;
};

}  // namespace gms_ransac
