// Second stage, faster: most reference descriptors are compared only with current ones near where their surroundings
// moved (doc/inside/guided_search.md).
#pragma once

#include <memory>
#include <vector>

#include "gms/motion_prediction.h"
#include "gms_ransac/features.h"
#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_statistics.h"
#include "matching/hamming_kernels.h"
#include "support/worker_pool.h"

namespace gms_ransac {

/// The current descriptors sorted by place, so that a search may look at those in a window alone.
class GuidedWindows {
 public:
  /// Copies the descriptors by buckets of a grid; `kernel` compares them for up to `threads` callers at a time.
  void setCurrent(const Features& current, const HammingKernel& kernel, int threads);

  /// Nearest two of the descriptors in the buckets that the rectangle touches. `thread`: one caller's, below that of
  /// setCurrent.
  NearestTwo search(const uint8_t* query, const cv::Point2f& center, const cv::Point2f& reach, int thread);

 private:
  int column(float x) const { return cellAt(x * buckets_per_pixel_, columns_); }
  int row(float y) const { return cellAt(y * buckets_per_pixel_, rows_); }

  const HammingKernel* kernel_ = nullptr;
  int columns_ = 0, rows_ = 0;
  float buckets_per_pixel_ = 1;
  std::vector<int32_t> bucket_;  ///< of each keypoint
  std::vector<int32_t> first_;   ///< place of each bucket's first descriptor, and one past the last
  std::vector<int32_t> index_;   ///< keypoint at each place
  std::vector<uint8_t> descriptors_;
  std::vector<RowRun> runs_;  ///< room for those of one window for each thread
};

class GuidedSearch {
 public:
  /// `statistics`: of the first matches, always with Criterion::kEvidence. `mutual` of the matcher must be off.
  GuidedSearch(const HammingMatcherOptions& matcher, const MotionStatisticsOptions& statistics);

  /// At most one match per reference descriptor, in reference order. Images without common motion get what
  /// HammingMatcher gives. `prior` is used if more first matches lie where it says than by chance, for points whose
  /// surroundings show no motion. The result depends neither on SIMD level nor threads; no allocation once warm.
  void match(const Features& reference, const Features& current, std::vector<Match>& matches,
             const MotionPrediction* prior = nullptr);

 private:
  bool chooseSeeds(const Features& reference, const Features& current);
  void searchAll(const DescriptorSet& reference, const DescriptorSet& current);
  int usualSecondDistance() const;
  bool confirm(const MotionPrediction& prior, const Features& current) const;
  /// True if matches that the prior sends out of view are as rare as by chance.
  bool nothingOutOfView(const MotionPrediction& prior, const cv::Size& image) const;
  void searchWindows(const Features& reference, const Features& current, const MotionPrediction& prediction,
                     const MotionPrediction* prior);

  const HammingKernel& kernel_;
  HammingMatcher matcher_;
  MotionStatisticsFilter gms_;
  MotionPredictor predictor_;
  GuidedWindows windows_;
  int threads_;
  std::shared_ptr<WorkerPool> pool_;

  std::vector<int> strongest_;  ///< kSeedsAPart of each part, the strongest first
  std::vector<int> chosen_;     ///< reference features to be compared with all
  std::vector<uint8_t> left_;   ///< of each reference feature, whether it is yet to be compared with all
  Features seeds_;
  DescriptorSet rows_;
  MotionStatistics statistics_;
  std::vector<Match> found_, matches_;  ///< of `chosen_`; of every reference feature
};

}  // namespace gms_ransac
