#include "gms_ransac/descriptor_set.h"

#include <cstring>
#include <stdexcept>

namespace gms_ransac {

void DescriptorSet::resize(int n) {
  size_ = n;
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

void DescriptorSet::pack() {}

}  // namespace gms_ransac
