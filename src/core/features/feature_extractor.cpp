#include "gms_ransac/feature_extractor.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <opencv2/features2d.hpp>

#include "features/simd_orb_extractor.h"

namespace gms_ransac {

namespace {

constexpr int kOrbPatchSize = 31;  // of the ORB descriptor, and so the border without keypoints

/// Levels that leave at least a pixel of the image: cv::ORB fails an assertion on those that do not.
int levelsThatFit(const cv::Size& size, const FeatureExtractorOptions& options) {
  const double factor = static_cast<float>(options.pyramid_scale);  // as cv::ORB stores it
  const auto side = static_cast<float>(std::min(size.width, size.height));
  int levels = 1;
  while (levels < options.pyramid_levels && std::lrint(side / static_cast<float>(std::pow(factor, levels))) > 0)
    ++levels;
  return levels;
}

/// ORB as OpenCV computes it: the extractor of the paper, kept for comparison.
class OpenCvExtractor : public FeatureExtractor {
 public:
  explicit OpenCvExtractor(const FeatureExtractorOptions& options)
      : options_(options),
        orb_(cv::ORB::create(options.features, static_cast<float>(options.pyramid_scale), options.pyramid_levels,
                             kOrbPatchSize, 0, 2, cv::ORB::HARRIS_SCORE, kOrbPatchSize, options.fast_threshold)) {}

 private:
  void extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) override {
    features.image_size = image.size();
    features.scale_factor = static_cast<float>(options_.pyramid_scale);
    features.keypoints.clear();
    // cv::ORB fails an assertion on images that are smaller than its patch.
    if (image.cols <= 2 * kOrbPatchSize || image.rows <= 2 * kOrbPatchSize) {
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

  FeatureExtractorOptions options_;
  cv::Ptr<cv::ORB> orb_;
  cv::Mat descriptors_;
};

}  // namespace

void FeatureExtractor::extract(const cv::Mat& image, Features& features, const cv::Mat& mask, int at_most) {
  if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != image.size())) {
    throw std::invalid_argument("FeatureExtractor: the mask must be CV_8UC1 and as large as the image");
  }
  extractWhere(mask, image, at_most, features);
}

std::unique_ptr<FeatureExtractor> makeFeatureExtractor(const FeatureExtractorOptions& options) {
  options.validate();
  if (options.extractor == "opencv") return std::make_unique<OpenCvExtractor>(options);
  return std::make_unique<SimdOrbExtractor>(options);
}

}  // namespace gms_ransac
