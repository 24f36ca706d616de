#include "gms_ransac/feature_extractor.h"

#include "features/opencv_extractor.h"
#include "features/simd_orb_extractor.h"
#include "validation.h"
#include "worker_pool.h"

namespace gms_ransac {

void FeatureExtractorOptions::validate() const {
  requireInRanges(*this);
  requireInRange("threads", threads, 1, kMostThreads);
}

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
