// Picks the tracked features for an estimator with room for few.
#pragma once

#include <cstdint>
#include <functional>
#include <unordered_set>
#include <vector>

#include <opencv2/core/types.hpp>

namespace gms_ransac {

/// A feature that TrackTable follows.
struct TrackedPoint {
  uint32_t id = 0;      ///< unique within the image, not 0
  int length = 0;       ///< images that hold the id
  cv::Point2f current;  ///< pixels of the current image
  int row = -1;         ///< of the MatchResult; -1: found without a keypoint
};

struct TrackSelectorOptions {
  /// Most features in an image; 0: any. VINS-Mono holds 1000 features over a window of eleven images unchecked: up to
  /// 222 points an image always fit.
  int limit = 220;
  double distance = 15;  ///< least distance between two of them, pixels; 0: any
};

/// Order: features picked before, then longest tracks, then sparse parts of the image. A picked feature that is
/// dropped is not picked again, so that no id returns after a gap.
class TrackSelector {
 public:
  using Usable = std::function<bool(const TrackedPoint&)>;
  /// `usable` is called for the points that would be picked, at most once for each; empty: all are usable.
  const std::vector<int>& select(const std::vector<TrackedPoint>& points, cv::Size image_size,
                                 const TrackSelectorOptions& options, const Usable& usable = {});

 private:
  /// Points in square cells at least as wide as the distance that is kept.
  class Grid {
   public:
    void reset(cv::Size image_size, double cell);
    int cells() const { return columns_ * rows_; }
    int cellOf(const cv::Point2f& point) const;
    void add(const cv::Point2f& point) { members_[cellOf(point)].push_back(point); }
    bool occupied(const cv::Point2f& point, double distance) const;

   private:
    int columns_ = 1, rows_ = 1;
    double cell_ = 1;  ///< pixels
    std::vector<std::vector<cv::Point2f>> members_;
  };
  struct Candidate {
    bool picked_before;
    int length;
    int rank;  ///< in its cell, from 0
    int index;
  };

  void sortCandidates(const std::vector<TrackedPoint>& points);
  void remember(const std::vector<TrackedPoint>& points);

  Grid grid_;
  std::vector<Candidate> candidates_;
  std::vector<int> picked_;
  std::unordered_set<uint32_t> picked_before_, given_way_;
};

}  // namespace gms_ransac
