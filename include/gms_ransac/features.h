// What is known of one image after extraction: keypoints and their 256-bit binary descriptors.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/types.hpp>

#include "gms_ransac/descriptor_set.h"

namespace gms_ransac {

/// Keypoints and descriptors of one image. Row i of `descriptors` belongs to `keypoints[i]`.
struct Features {
  cv::Size image_size;                  ///< pixels of the received image
  float scale_factor = 1.2f;            ///< between pyramid levels; a keypoint of octave l has noise scale_factor^l px
  std::vector<cv::KeyPoint> keypoints;  ///< pt: pixels of the received image; octave: pyramid level; angle: degrees
  DescriptorSet descriptors;            ///< packed for matching by the extractor

  int size() const { return static_cast<int>(keypoints.size()); }
};

}  // namespace gms_ransac
