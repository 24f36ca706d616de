// The current descriptors sorted by place, so that a search may look at those in a window alone.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/features.h"
#include "matching/hamming_kernels.h"

namespace gms_ransac {

class GuidedWindows {
 public:
  /// Copies the descriptors, bucket by bucket of a grid over the image, row by row; `kernel` will compare them, at the
  /// call of up to so many `seats` at a time.
  void setCurrent(const Features& current, const HammingKernel& kernel, int seats);

  /// Nearest and second nearest of the descriptors whose keypoints are in the rectangle, or in a bucket that it cuts.
  /// `seat`: below that of setCurrent, of one caller at a time.
  NearestTwo search(const uint8_t* query, const cv::Point2f& center, const cv::Point2f& reach, int seat);

 private:
  int column(float x) const;
  int row(float y) const;

  const HammingKernel* kernel_ = nullptr;
  int columns_ = 0, rows_ = 0;
  float buckets_per_pixel_ = 1;
  std::vector<int32_t> bucket_;  ///< of each keypoint
  std::vector<int32_t> first_;   ///< place of each bucket's first descriptor, and one past the last
  std::vector<int32_t> index_;   ///< keypoint at each place
  std::vector<uint8_t> descriptors_;
  std::vector<RowRun> runs_;  ///< room for those of one window for each seat
};

}  // namespace gms_ransac
