// Finds a pattern that repeats itself: matches that agree on a motion may then all be one period off.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "matching/hamming_kernels.h"

namespace gms_ransac {

/// Keeps its storage from pair to pair.
class Repetition {
 public:
  explicit Repetition(SimdLevel simd) : kernel_(hammingKernel(simd)) {}

  /// The period of the pattern, pixels of the current image; nothing if there is none. Many inliers then look like
  /// another place there as well, as far away as that of their neighbours. Descriptors have 256 bits. `inlier`: flags
  /// of the matches.
  std::optional<double> period(const Features& reference, const Features& current, const std::vector<Match>& matches,
                               const std::vector<uint8_t>& inlier);

 private:
  struct Sample {
    cv::Point2f point;
    std::vector<cv::Point2f> elsewhere;  ///< from the point to other places that look like it
  };
  void findElsewhere(const uint8_t* query, const cv::KeyPoint& place, const Features& current, int most,
                     Sample& sample);
  /// Sets `near_`. `most`: square of the distance, pixels.
  void markNear(const cv::Point2f& point, float most);
  /// The length of a step that the sample shares with neighbours within `radius`, pixels, if it shares one.
  std::optional<float> sharedStep(const Sample& sample, float radius) const;

  const HammingKernel& kernel_;
  std::vector<size_t> inliers_;
  std::vector<float> distances_;
  std::vector<int32_t> index_;
  std::vector<float> x_, y_;   ///< of the current keypoints
  std::vector<uint8_t> near_;  ///< 1: on the patch that was found last
  std::vector<RowRun> runs_;
  std::vector<Sample> samples_;
  std::vector<float> periods_;
};

}  // namespace gms_ransac
