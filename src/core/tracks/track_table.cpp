#include "gms_ransac/track_table.h"

#include <algorithm>
#include <limits>

namespace gms_ransac {

void TrackTable::link(const MatchResult& result) {
  // A reference that was never linked (the first one, or the one after a reset) has no tracks yet.
  reference_.resize(static_cast<size_t>(result.keypoints_reference));
  current_.assign(static_cast<size_t>(result.keypoints_current), Track());
  owner_.assign(current_.size(), -1);
  ids_.assign(result.matches.size(), 0);
  lengths_.assign(result.matches.size(), 0);

  for (size_t m = 0; m < result.matches.size(); ++m) {
    if (result.stage[m] != MatchStage::kInlier) continue;
    int32_t& owner = owner_[static_cast<size_t>(result.matches[m].current)];
    if (owner < 0 || result.matches[m].distance < result.matches[static_cast<size_t>(owner)].distance) {
      owner = static_cast<int32_t>(m);
    }
  }
  for (size_t j = 0; j < current_.size(); ++j) {
    if (owner_[j] < 0) continue;
    const auto m = static_cast<size_t>(owner_[j]);
    Track& from = reference_[static_cast<size_t>(result.matches[m].reference)];
    if (from.id == 0) from = {next_id_++, 1};
    const int seen = std::min<int>(from.length + 1, std::numeric_limits<uint16_t>::max());
    current_[j] = {from.id, static_cast<uint16_t>(seen)};
    ids_[m] = current_[j].id;
    lengths_[m] = current_[j].length;
  }
}

void TrackTable::advance() {
  reference_.swap(current_);
  current_.clear();
}

void TrackTable::reset() {
  reference_.clear();
  current_.clear();
  ids_.clear();
  lengths_.clear();
}

}  // namespace gms_ransac
