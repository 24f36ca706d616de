#include "gms_ransac/past.h"

#include <algorithm>
#include <cstddef>

#include <opencv2/core/mat.hpp>

namespace gms_ransac {

namespace {

constexpr int kSampledRows = 64;

/// Tells images apart by the descriptors of some keypoints (FNV-1a). Copies of an image's features, also with keypoints
/// that were moved, have the same. Not 0.
uint64_t fingerprint(const Features& features) {
  uint64_t hash = 0xcbf29ce484222325;
  const auto mix = [&hash](uint64_t value) { hash = (hash ^ value) * 0x100000001b3; };
  const cv::Mat rows = features.descriptors.asMat();
  mix(static_cast<uint64_t>(rows.rows));
  const int step = std::max(1, rows.rows / kSampledRows);
  const size_t bytes = static_cast<size_t>(rows.cols) * rows.elemSize();
  for (int i = 0; i < rows.rows; i += step) {
    const uint8_t* row = rows.ptr(i);
    for (size_t k = 0; k < bytes; ++k) mix(row[k]);
  }
  return std::max<uint64_t>(hash, 1);
}

}  // namespace

void Past::startPair(const Features& reference, const Features& current) {
  const uint64_t image = fingerprint(reference);
  if (image == current_image) {
    reference_static.swap(current_static);
    direction = current_direction;
    guess = current_guess;
    shutter.advance();
  } else if (image != reference_image) {
    shutter.advance();
    shutter.advance();  // the chain of pairs breaks
    Past of_camera;
    of_camera.shutter = shutter;
    of_camera.mask = mask;
    *this = of_camera;
  }
  if (mask.imageSize() != current.image_size) mask = LearnedMask(current.image_size);
  reference_image = image;
  current_image = fingerprint(current);
  current_static.clear();
}

}  // namespace gms_ransac
