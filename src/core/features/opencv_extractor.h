// ORB as OpenCV computes it: the extractor of the paper, kept for comparison.
#pragma once

#include <opencv2/features2d.hpp>

#include "gms_ransac/feature_extractor.h"

namespace gms_ransac {

class OpenCvExtractor : public FeatureExtractor {
 public:
  explicit OpenCvExtractor(const FeatureExtractorOptions& options);

 private:
  void extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) override;

  FeatureExtractorOptions options_;
  cv::Ptr<cv::ORB> orb_;
  cv::Mat descriptors_;
};

}  // namespace gms_ransac
