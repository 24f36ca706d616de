// Our ORB: the same descriptor as cv::ORB's on keypoints that are found faster, spread better and located more finely.
#pragma once

#include <vector>

#include "features/blur.h"
#include "features/corner_detector.h"
#include "features/corner_selector.h"
#include "features/kernels.h"
#include "features/pyramid.h"
#include "gms_ransac/feature_extractor.h"

namespace gms_ransac {

class FastExtractor : public FeatureExtractor {
 public:
  explicit FastExtractor(const FeatureExtractorOptions& options);
  void extract(const cv::Mat& image, Features& features) override;

 private:
  struct Level {
    CornerDetector detector;
    CornerSelector selector;
    Blur blur;
    Plane blurred;
    std::vector<Corner> corners;
    int first_keypoint = 0;
  };

  void detect(int level);
  void shareOut();
  void select(int level);
  void describe(int level, Features& features);
  cv::Point2f refine(int level, const Corner& corner) const;

  FeatureExtractorOptions options_;
  const FeatureKernels& kernels_;
  Pyramid pyramid_;
  std::vector<Level> levels_;
  std::vector<int> quota_;
};

}  // namespace gms_ransac
