#include "keyframe_store.h"

#include <algorithm>

using gms_ransac::Features;
using gms_ransac::Match;

bool KeyframeStore::isNewView(const std::vector<uint32_t>& track_ids) const {
  const auto known = [this](uint32_t id) {
    return std::binary_search(newest_tracks_.begin(), newest_tracks_.end(), id);
  };
  const auto still = std::count_if(track_ids.begin(), track_ids.end(), known);
  return 2 * static_cast<size_t>(still) <= newest_tracks_.size();
}

std::optional<KeyframeStore::Loop> KeyframeStore::findLoop(const Features& image) {
  std::optional<Loop> best;
  int most = kSameView - 1;
  for (size_t i = 0; i + latest_ < keyframes_.size(); ++i) {
    matcher_.match(keyframes_[i].descriptors, image.descriptors, matches_);
    filter_.compute(keyframes_[i], image, matches_, statistics_);
    if (statistics_.accepted_count <= most) continue;
    most = statistics_.accepted_count;
    best = Loop{i, {}};
    for (size_t m = 0; m < matches_.size(); ++m) {
      if (statistics_.accepted[m]) best->matches.push_back(matches_[m]);
    }
  }
  return best;
}

size_t KeyframeStore::add(Features image, std::vector<uint32_t> track_ids) {
  keyframes_.push_back(std::move(image));
  std::sort(track_ids.begin(), track_ids.end());
  track_ids.erase(track_ids.begin(), std::upper_bound(track_ids.begin(), track_ids.end(), 0u));
  newest_tracks_ = std::move(track_ids);
  return keyframes_.size() - 1;
}
