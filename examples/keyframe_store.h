// Keyframes by their descriptors alone, and which of them an image shows again: by matching, without a vocabulary.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "gms_ransac/hamming_matcher.h"
#include "gms_ransac/motion_statistics.h"

/// A keyframe for every view, 130 kB each at 1000 features; every new one is compared with all but the latest, at half
/// a millisecond each: a store for rooms, not for cities.
class KeyframeStore {
 public:
  /// `latest`: keyframes that see about the same and are no loop.
  explicit KeyframeStore(size_t latest = 10) : latest_(latest) {}

  /// The view has changed: not half of the keypoints that the newest keyframe tracked are tracked still.
  bool isNewView(const std::vector<uint32_t>& track_ids) const;

  struct Loop {
    size_t keyframe;                         ///< in the order they were added
    std::vector<gms_ransac::Match> matches;  ///< keyframe (reference) to image (current), as the motion statistics keep
  };
  /// The keyframe that shows the same, if any but the latest does.
  std::optional<Loop> findLoop(const gms_ransac::Features& image);

  size_t add(gms_ransac::Features image, std::vector<uint32_t> track_ids);
  const gms_ransac::Features& operator[](size_t keyframe) const { return keyframes_[keyframe]; }

 private:
  // Once round the rendered room no two views of different things keep as many (test/loops_test.cpp).
  static constexpr int kSameView = 60;

  size_t latest_;
  std::vector<gms_ransac::Features> keyframes_;
  std::vector<uint32_t> newest_tracks_;  ///< sorted, without 0
  gms_ransac::HammingMatcher matcher_;
  gms_ransac::MotionStatisticsFilter filter_;
  std::vector<gms_ransac::Match> matches_;
  gms_ransac::MotionStatistics statistics_;
};
