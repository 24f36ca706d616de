#include "tracks/track_table.h"

#include <algorithm>
#include <limits>

namespace gms_ransac {

void TrackTable::link(const MatchResult& result) {
  // A reference that was never linked (the first one, or the one after a reset) has no tracks yet.
  reference_.resize(static_cast<size_t>(result.keypoints_reference));
  current_.assign(static_cast<size_t>(result.keypoints_current), Track());
  ids_.assign(result.matches.size(), 0);
  lengths_.assign(result.matches.size(), 0);
  // The best inlier of each current keypoint.
  owner_.assign(current_.size(), -1);
  bool found = false;
  for (size_t row = 0; row < result.matches.size(); ++row) {
    if (!result.isInlier(row)) continue;
    found = true;
    int32_t& owner = owner_[static_cast<size_t>(result.matches[row].current)];
    if (owner < 0 || result.matches[row].distance < result.matches[static_cast<size_t>(owner)].distance) {
      owner = static_cast<int32_t>(row);
    }
  }
  if (!found) return;

  const uint32_t previous_link = link_++;
  if (wrapped_) noteLiving();
  for (size_t j = 0; j < current_.size(); ++j) {
    if (owner_[j] < 0) continue;
    const auto row = static_cast<size_t>(owner_[j]);
    Track& track = reference_[static_cast<size_t>(result.matches[row].reference)];
    if (track.id == 0 || track.link != previous_link) track = {newId(), 1, 0};
    const int seen = std::min<int>(track.length + 1, std::numeric_limits<uint16_t>::max());
    track = {track.id, static_cast<uint16_t>(seen), link_};
    current_[j] = track;
    ids_[row] = track.id;
    lengths_[row] = track.length;
  }
}

uint32_t TrackTable::newId() {
  uint32_t id;
  do {
    if (next_id_ == 0) {
      next_id_ = 1;
      wrapped_ = true;
      noteLiving();
    }
    id = next_id_++;
  } while (wrapped_ && std::binary_search(living_.begin(), living_.end(), id));
  return id;
}

void TrackTable::noteLiving() {
  living_.clear();
  for (const Track& track : reference_) living_.push_back(track.id);
  std::sort(living_.begin(), living_.end());
}

void TrackTable::advance() {
  reference_.swap(current_);
  current_.clear();
}

void TrackTable::numberFrom(const TrackTable& last) {
  next_id_ = last.next_id_;
  wrapped_ = last.wrapped_;
  link_ = last.link_;
}

void TrackTable::reset() {
  reference_.clear();
  current_.clear();
  ids_.clear();
  lengths_.clear();
}

}  // namespace gms_ransac
