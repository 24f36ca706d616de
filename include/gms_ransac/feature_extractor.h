// First stage, image -> features: ORB keypoints and descriptors.
#pragma once

#include <limits>
#include <memory>
#include <string>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/features.h"
#include "gms_ransac/simd.h"

namespace gms_ransac {

struct FeatureExtractorOptions {
  std::string extractor = "simd_orb";  ///< "simd_orb": ours; "opencv": cv::ORB, what the paper used
  int features = 2000;                 ///< keypoints asked for per image
  int pyramid_levels = 5;
  double pyramid_scale =
      1.41;  ///< between levels; cv::ORB has 8 of 1.2 by default: the same reach, 1.6 times the pixels
  /// FAST contrast, grey levels. "opencv" ignores fainter corners; "simd_orb" takes the strongest and stops only at 7,
  /// at 4 where texture is low, or here if this is less.
  int fast_threshold = 20;
  /// "simd_orb": so many threads share the pyramid levels; the result does not depend on it.
  int threads = 1;
  SimdLevel simd = detectSimdLevel();

  void validate() const;
};

class FeatureExtractor {
 public:
  virtual ~FeatureExtractor() = default;
  /// `image`: CV_8UC1; that of a sensor of few pixels (a side below 100) is enlarged; beyond Features::kLargestSide it
  /// gives no features. `mask`: empty, or CV_8UC1 of that size; zero where no keypoint may lie. `at_most`: fewer
  /// keypoints than the options ask for. Overwrites `features`, whose descriptors are packed. Throws
  /// std::invalid_argument for a wrong mask.
  void extract(const cv::Mat& image, Features& features, const cv::Mat& mask = cv::Mat(),
               int at_most = std::numeric_limits<int>::max());

 private:
  virtual void extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) = 0;

  cv::Mat enlarged_, enlarged_mask_;
};

std::unique_ptr<FeatureExtractor> makeFeatureExtractor(const FeatureExtractorOptions& options);

}  // namespace gms_ransac
