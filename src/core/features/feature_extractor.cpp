#include "gms_ransac/feature_extractor.h"

#include <stdexcept>

#include "features/fast_extractor.h"
#include "features/opencv_extractor.h"
#include "validation.h"

namespace gms_ransac {

void FeatureExtractorOptions::validate() const {
  if (extractor != "opencv" && extractor != "fast") {
    throw std::invalid_argument("extractor is '" + extractor + "'; it must be 'fast' or 'opencv'");
  }
  requireInRange("features", features, 1, 100000);
  requireInRange("levels", levels, 1, 16);
  requireInRange("scale_factor", scale_factor, 1.01, 2.0);
  requireInRange("fast_threshold", fast_threshold, 0, 255);
  requireInRange("threads", threads, 1, 64);
}

std::unique_ptr<FeatureExtractor> makeFeatureExtractor(const FeatureExtractorOptions& options) {
  options.validate();
  if (options.extractor == "fast") return std::make_unique<FastExtractor>(options);
  return std::make_unique<OpenCvExtractor>(options);
}

}  // namespace gms_ransac
