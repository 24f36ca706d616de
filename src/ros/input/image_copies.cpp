#include "input/image_copies.h"

#include <cstring>

#include <opencv2/core.hpp>

namespace gms_ransac {

namespace {

/// Share of the rows that have more than one colour in any image that is not dark: of a covered lens hot pixels alone
/// do.
constexpr double kLeastRows = 0.1;

const char* const kWhole = "it is a copy of the image before it, bit for bit";

/// True if the pixels of a row repeat with this period, bytes.
bool isPlain(const uint8_t* row, size_t bytes, size_t period) {
  return bytes <= period || std::memcmp(row, row + period, bytes - period) == 0;
}

}  // namespace

std::string copiedPart(const sensor_msgs::Image& before, const sensor_msgs::Image& image) {
  const size_t row = image.step;
  const bool same_kind = before.width == image.width && before.height == image.height && before.step == image.step &&
                         before.encoding == image.encoding && before.data.size() == image.data.size();
  // An image that is still compressed says no size.
  if (same_kind && image.width == 0 && !image.data.empty() && before.data == image.data) return kWhole;
  // A depth image or a right one has not been refused yet if its rows hold no pixels, and may claim any number of them.
  if (!same_kind || image.width == 0 || row < image.width || image.data.size() < row * image.height)
    return std::string();
  const size_t period = 2 * (row / image.width);  // two pixels: of a Bayer pattern, or with shared colours
  size_t rows = 0, copied = 0;
  for (size_t y = 0; y < image.height; ++y) {
    const uint8_t* pixels = image.data.data() + y * row;
    if (isPlain(pixels, row, period)) continue;
    ++rows;
    copied += std::memcmp(pixels, before.data.data() + y * row, row) == 0;
  }
  const bool dark = static_cast<double>(rows) < kLeastRows * image.height;
  if (dark || 2 * copied < rows) return std::string();
  if (copied == rows) return kWhole;
  return cv::format("%zu of its %zu rows are a copy of the image before it, bit for bit", copied, rows);
}

std::string copiedPart(const Keypoints& before, const Keypoints& keypoints) {
  const bool same = !keypoints.u.empty() && before.u == keypoints.u && before.v == keypoints.v &&
                    before.descriptors == keypoints.descriptors;
  return same ? "its keypoints are a copy of those before it, bit for bit" : std::string();
}

}  // namespace gms_ransac
