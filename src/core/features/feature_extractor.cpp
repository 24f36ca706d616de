#include "gms_ransac/feature_extractor.h"

#include "features/fast_extractor.h"
#include "features/opencv_extractor.h"
#include "validation.h"

namespace gms_ransac {

void FeatureExtractorOptions::validate() const {
  requireInRanges(*this);
  requireInRange("threads", threads, 1, 64);
}

std::unique_ptr<FeatureExtractor> makeFeatureExtractor(const FeatureExtractorOptions& options) {
  options.validate();
  if (options.extractor == "fast") return std::make_unique<FastExtractor>(options);
  return std::make_unique<OpenCvExtractor>(options);
}

}  // namespace gms_ransac
