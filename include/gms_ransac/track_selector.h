// Picks, image after image, the followed features that an estimator with room for few of them is given.
#pragma once

#include <cstdint>
#include <unordered_set>
#include <vector>

#include <opencv2/core/types.hpp>

namespace gms_ransac {

/// A feature that TrackTable follows.
struct TrackedPoint {
  uint32_t id = 0;      ///< unique within the image, not 0
  int length = 0;       ///< images that hold the id
  cv::Point2f current;  ///< pixels of the current image
};

struct TrackSelectorOptions {
  /// Most features picked in an image; 0: any number. VINS-Mono has arrays for 1000 features over its window of eleven
  /// images and does not look whether they suffice. It counts those that begin in the first eight and are seen twice,
  /// so at worst, with every track two images long, nine images with two features for each pair of points: up to 222
  /// points an image always fit.
  int limit = 220;
  double distance = 15;  ///< least distance between two of them, pixels; 0: any
};

/// Features that were picked before come first, as long as they are followed; then those with the longest tracks, and
/// of equal ones those in parts of the image that have few. One that was picked and had to give way to another, too
/// near or more than the limit, is not picked again, so that no id comes back after a gap.
class TrackSelector {
 public:
  /// Indices of the picked points, those that come first in front. Depends on nothing but what it was given so far.
  const std::vector<int>& select(const std::vector<TrackedPoint>& points, cv::Size image_size,
                                 const TrackSelectorOptions& options);

 private:
  /// Square cells with the points that were put into them; a cell is at least as wide as the distance that is kept.
  class Grid {
   public:
    void reset(cv::Size image_size, double cell);
    int cells() const { return columns_ * rows_; }
    int cellOf(const cv::Point2f& point) const;
    void add(const cv::Point2f& point) { members_[cellOf(point)].push_back(point); }
    /// Whether a point that was added is nearer than `distance`.
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
