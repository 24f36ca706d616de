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
  int pyramid_levels = 8;
  double pyramid_scale = 1.2;  ///< between levels
  /// FAST contrast in grey levels; above 3000 features 0 is usual. "opencv" ignores fainter corners; "simd_orb"
  /// takes the strongest there are and stops only at 7, at 4 where texture is low, or here if this is less.
  int fast_threshold = 20;
  /// "simd_orb": so many threads share the pyramid levels; the result does not depend on it.
  int threads = 1;
  SimdLevel simd = detectSimdLevel();

  /// Throws std::invalid_argument with a sentence that names the parameter, its value and its range
  /// (cfg/parameters.py).
  void validate() const;
};

class FeatureExtractor {
 public:
  virtual ~FeatureExtractor() = default;
  /// `image`: CV_8UC1, any size (too small for a keypoint, or beyond 65535 pixels a side: no features, not an error).
  /// `mask`: empty, or CV_8UC1 of the image's size: keypoints are taken where it is not zero, all that are asked for.
  /// The pixel nearest to a keypoint of "simd_orb" is never masked; "opencv" is less exact, by half a pixel of the
  /// level. `at_most`: keypoints, where fewer than the options ask for are wanted. Overwrites `features`, reusing its
  /// storage; descriptors are packed. Throws std::invalid_argument when the mask is of another type or size.
  void extract(const cv::Mat& image, Features& features, const cv::Mat& mask = cv::Mat(),
               int at_most = std::numeric_limits<int>::max());

 private:
  virtual void extractWhere(const cv::Mat& mask, const cv::Mat& image, int at_most, Features& features) = 0;
};

/// Validates the options and builds the extractor they name; takes earlier names too.
std::unique_ptr<FeatureExtractor> makeFeatureExtractor(const FeatureExtractorOptions& options);

}  // namespace gms_ransac
