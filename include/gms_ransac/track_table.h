// Persistent ids for features that are followed from pair to pair.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

/// The inlier matches of a pair carry the id of the reference keypoint on to the current one; a keypoint that is
/// matched for the first time gets a new id. Ids start at 1, are unique within an image and never used twice, not even
/// after a reset. 0 means "not followed".
class TrackTable {
 public:
  /// Links the keypoints of the reference to those of the current image. Of several inliers that end on one current
  /// keypoint the one of smallest Hamming distance (the first on ties) keeps its id, the others get 0.
  /// Call again without `advance` when the same reference is compared with another image.
  void link(const MatchResult& result);
  /// The current image of the last `link` becomes the reference of the next.
  void advance();
  /// Nothing is followed any more; the next ids are new ones.
  void reset();

  /// Columns beside MatchResult::matches of the last `link`; 0 where the match is not an inlier.
  const std::vector<uint32_t>& ids() const { return ids_; }
  /// Images in which the feature has been seen, the current one included: 2 or more for a followed one.
  const std::vector<uint16_t>& lengths() const { return lengths_; }

 private:
  /// Of one keypoint.
  struct Track {
    uint32_t id = 0;
    uint16_t length = 0;
  };
  std::vector<Track> reference_, current_;
  std::vector<int32_t> owner_;  ///< match that holds each current keypoint, -1: none
  std::vector<uint32_t> ids_;
  std::vector<uint16_t> lengths_;
  uint32_t next_id_ = 1;
};

}  // namespace gms_ransac
