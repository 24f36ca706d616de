// Persistent ids for features that are followed from pair to pair.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

/// The inlier matches of a pair carry the id of the reference keypoint on to the current one; a keypoint that is
/// matched for the first time gets a new id. Ids start at 1, are unique within an image and never used twice, not even
/// after a reset. 0 means "not followed".
///
/// The images that hold an id follow on each other without a gap, for that is how estimators file them: a keypoint of a
/// held reference that one image misses and the next finds again has a new id there. Only an image that shows nothing
/// of the reference (no inlier at all) ends no track.
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

  /// Of one keypoint.
  struct Track {
    uint32_t id = 0;
    uint16_t length = 0;
    uint32_t link = 0;  ///< number of the last link that found it
  };
  /// Of the reference's keypoints, to go back to that image with.
  const std::vector<Track>& tracks() const { return reference_; }
  /// An earlier image, whose tracks these are, is the reference of the next `link`. Those go on that were not missed by
  /// an image since: they are among `newest`, the tracks of the last image that held any, and no link has found others.
  void goBack(const std::vector<Track>& tracks, const std::vector<Track>& newest);

  /// Columns beside MatchResult::matches of the last `link`; 0 where the match is not an inlier.
  const std::vector<uint32_t>& ids() const { return ids_; }
  /// Images that hold the id, the current one and the one it was first matched from included: 2 or more.
  const std::vector<uint16_t>& lengths() const { return lengths_; }

 private:
  /// Of the inliers that end on each current keypoint the best; false: there is no inlier.
  bool findOwners(const MatchResult& result);

  std::vector<Track> reference_, current_;
  std::vector<int32_t> owner_;  ///< match that holds each current keypoint, -1: none
  std::vector<uint32_t> ids_;
  std::vector<uint16_t> lengths_;
  uint32_t next_id_ = 1;
  uint32_t link_ = 0;  ///< number of the last link that found anything
};

}  // namespace gms_ransac
