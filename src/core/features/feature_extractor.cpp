#include "gms_ransac/feature_extractor.h"

#include <stdexcept>

#include "features/opencv_extractor.h"
#include "features/simd_orb_extractor.h"
#include "validation.h"

namespace gms_ransac {

std::string currentExtractorName(const std::string& name) { return name == "fast" ? "simd_orb" : name; }

void FeatureExtractorOptions::validate() const {
  if (extractor != "opencv" && currentExtractorName(extractor) != "simd_orb") {
    throw std::invalid_argument("extractor is '" + extractor + "'; it must be 'simd_orb' or 'opencv'");
  }
  requireInRange("features", features, 1, 100000);
  requireInRange("levels", levels, 1, 16);
  requireInRange("scale_factor", scale_factor, 1.01, 2.0);
  requireInRange("fast_threshold", fast_threshold, 0, 255);
  requireInRange("threads", threads, 1, 64);
}

void FeatureExtractor::extract(const cv::Mat& image, Features& features, const cv::Mat& mask) {
  if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != image.size())) {
    throw std::invalid_argument("FeatureExtractor: the mask must be CV_8UC1 and as large as the image");
  }
  extractWhere(mask, image, features);
}

std::unique_ptr<FeatureExtractor> makeFeatureExtractor(const FeatureExtractorOptions& options) {
  options.validate();
  if (options.extractor == "opencv") return std::make_unique<OpenCvExtractor>(options);
  return std::make_unique<SimdOrbExtractor>(options);
}

}  // namespace gms_ransac
