#include "gms_ransac/descriptor_set.h"

#include <cstring>
#include <stdexcept>

#include "matching/hamming_kernels.h"

namespace gms_ransac {

static_assert(kDescriptorBytes == kHammingBytes, "the kernels compare whole descriptors");

void DescriptorSet::resize(int n) {
  size_ = n;
  is_packed_ = false;
  const size_t bytes = static_cast<size_t>(n) * kDescriptorBytes;
  if (rows_.size() < bytes) rows_.resize(bytes);
}

cv::Mat DescriptorSet::asMat() const {
  return cv::Mat(size_, kDescriptorBytes, CV_8U, const_cast<uint8_t*>(rows_.data()));
}

void DescriptorSet::assign(const cv::Mat& rows) {
  if (!rows.empty() && (rows.type() != CV_8UC1 || rows.cols != kDescriptorBytes)) {
    throw std::invalid_argument("descriptors must be an N x 32 matrix of bytes");
  }
  resize(rows.rows);
  for (int i = 0; i < size_; ++i) std::memcpy(row(i), rows.ptr(i), kDescriptorBytes);
  pack();
}

void DescriptorSet::pack(SimdLevel level) {
  const HammingKernel& kernel = hammingKernel(level);
  const size_t lines = (kernel.packedBytes(size_) + sizeof(CacheLine) - 1) / sizeof(CacheLine);
  if (packed_.size() < lines) packed_.resize(lines);
  if (lines > 0) kernel.pack(rows_.data(), size_, packed_.front().bytes);
  is_packed_ = true;
  packed_level_ = level;
}

}  // namespace gms_ransac
