// The room tracks knows which keypoints of successive images are one point. It reads results and changes none.
//
// Persistent ids for features that are followed from pair to pair.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/match_result.h"

namespace gms_ransac {

/// Inlier matches carry the id of the reference keypoint to the current one; a new match gets a new id. Ids count up
/// from 1; 0 is "not followed". After the largest they begin again at 1, without those of tracks that still go on. The
/// images of an id follow on each other without a gap. An image without any inlier is skipped: it ends no track.
class TrackTable {
 public:
  explicit TrackTable(uint32_t first_id = 1) : next_id_(first_id) {}

  /// Links reference to current keypoints. If several inliers share a current keypoint, the one of smallest
  /// Hamming distance keeps its id. Call again without `advance` to compare the reference with another image.
  void link(const MatchResult& result);
  void advance();
  void reset();

  /// Called on an earlier copy that the stream goes back to: continues the ids and links of `last`. Tracks go on that
  /// no image with inliers missed since.
  void numberFrom(const TrackTable& last);

  /// One id per row of the last `link`; 0 for those that are no inliers.
  const std::vector<uint32_t>& ids() const { return ids_; }
  /// Number of images with the id, 2 or more.
  const std::vector<uint16_t>& lengths() const { return lengths_; }

 private:
  struct Track {
    uint32_t id = 0;
    uint16_t length = 0;
    uint32_t link = 0;  ///< number of the last link that found it
  };
  uint32_t newId();
  void noteLiving();

  std::vector<Track> reference_, current_;
  std::vector<int32_t> owner_;  ///< row that holds each current keypoint, -1: none
  std::vector<uint32_t> ids_;
  std::vector<uint16_t> lengths_;
  uint32_t next_id_;
  bool wrapped_ = false;
  std::vector<uint32_t> living_;  ///< once wrapped: ids of the reference's tracks, sorted
  uint32_t link_ = 0;             ///< number of the last link that found anything
};

}  // namespace gms_ransac
