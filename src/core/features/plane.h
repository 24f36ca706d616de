// An 8-bit image whose rows vector code may overrun: every row starts on a cache line, with slack around the whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gms_ransac {

class Plane {
 public:
  /// Bytes that may be read or written before the first row and after the last.
  static constexpr int kSlack = 128;

  /// Sets the size in pixels; the contents are unspecified afterwards. Allocates only to grow.
  void resize(int width, int height) {
    width_ = width;
    height_ = height;
    stride_ = (width + kLine - 1) / kLine * kLine;
    // Rows a multiple of 1024 bytes apart would share a few cache sets.
    if (stride_ % 1024 == 0) stride_ += kLine;
    const size_t bytes = static_cast<size_t>(stride_) * height + 2 * kSlack + kLine;
    if (storage_.size() < bytes) storage_.resize(bytes);
    const auto address = reinterpret_cast<uintptr_t>(storage_.data()) + kSlack;
    first_ = storage_.data() + kSlack + (kLine - address % kLine) % kLine;
  }

  int width() const { return width_; }
  int height() const { return height_; }
  ptrdiff_t stride() const { return stride_; }
  uint8_t* row(int y) { return first_ + y * stride_; }
  const uint8_t* row(int y) const { return first_ + y * stride_; }

 private:
  static constexpr int kLine = 64;
  int width_ = 0;
  int height_ = 0;
  ptrdiff_t stride_ = 0;
  uint8_t* first_ = nullptr;
  std::vector<uint8_t> storage_;
};

}  // namespace gms_ransac
