#include "features/opencv_extractor.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

namespace {

constexpr int kPatchSize = 31;  // of the ORB descriptor, and so the border without keypoints

/// Levels that leave at least a pixel of the image: cv::ORB fails an assertion on those that do not.
int levelsThatFit(const cv::Size& size, const FeatureExtractorOptions& options) {
  const double factor = static_cast<float>(options.pyramid_scale);  // as cv::ORB stores it
  const auto side = static_cast<float>(std::min(size.width, size.height));
  int levels = 1;
  while (levels < options.pyramid_levels && std::lrint(side / static_cast<float>(std::pow(factor, levels))) > 0)
    ++levels;
  return levels;
}

}  // namespace

OpenCvExtractor::OpenCvExtractor(const FeatureExtractorOptions& options)
    : options_(options),
      orb_(cv::ORB::create(options.features, static_cast<float>(options.pyramid_scale), options.pyramid_levels,
                           kPatchSize, 0, 2, cv::ORB::HARRIS_SCORE, kPatchSize, options.fast_threshold)) {}

void OpenCvExtractor::extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) {
  features.image_size = image.size();
  features.scale_factor = static_cast<float>(options_.pyramid_scale);
  features.keypoints.clear();
  // cv::ORB fails an assertion on images that are smaller than its patch.
  if (image.cols <= 2 * kPatchSize || image.rows <= 2 * kPatchSize) {
    features.descriptors.resize(0);
    features.descriptors.pack();
    return;
  }
  orb_->setMaxFeatures(std::min(options_.features, at_most));
  orb_->setNLevels(levelsThatFit(image.size(), options_));
  // cv::ORB scales the mask to its levels and uses what stays 255.
  cv::Mat used;
  if (!mask.empty()) used = mask != 0;
  orb_->detectAndCompute(image, used, features.keypoints, descriptors_);
  features.descriptors.assign(descriptors_);
}

}  // namespace gms_ransac
