#include "gms_ransac/features.h"

#include <cmath>
#include <stdexcept>

namespace gms_ransac {

namespace {

[[noreturn]] void refuseFeatures(const std::string& what) { throw std::invalid_argument("Features: " + what); }

}  // namespace

void Features::validate() const {
  if (image_size.empty()) refuseFeatures("image_size is not set; it must be that of the image, in pixels");
  if (!(scale_factor > 1) || !std::isfinite(scale_factor)) refuseFeatures("scale_factor is not above 1");
  if (descriptors.size() != size()) {
    refuseFeatures("there are " + std::to_string(size()) + " keypoints and " + std::to_string(descriptors.size()) +
                   " descriptors; each keypoint must have one");
  }
  for (int i = 0; i < size(); ++i) {
    const cv::KeyPoint& keypoint = keypoints[static_cast<size_t>(i)];
    const auto at = [i] { return "keypoint " + std::to_string(i); };
    if (!isInImage(keypoint.pt.x, image_size.width) || !isInImage(keypoint.pt.y, image_size.height)) {
      refuseFeatures(at() + " lies outside the image");
    }
    if (keypoint.octave < 0 || keypoint.octave >= kOctaves) {
      refuseFeatures(at() + " has octave " + std::to_string(keypoint.octave) +
                     "; it must be a pyramid level, 0 to 15 (that of cv::SIFT is its lowest byte plus 1)");
    }
    if (!isAngle(keypoint.angle)) refuseFeatures(at() + " has no angle within 360 degrees; -1 is unknown");
  }
}

}  // namespace gms_ransac
