// ~stereo_features: the points that FeatureStream follows and both cameras see, as msckf_vio takes them.
#pragma once

#include <optional>
#include <unordered_map>

#include <gms_ransac/StereoFeatures.h>

#include "output/feature_stream.h"

namespace gms_ransac {

/// FeatureStream of the left camera. The patch around a point is aligned along its row of the right image; the track of
/// a point that is not found there ends.
class StereoFeatureStream {
 public:
  StereoFeatureStream() : stream_(InputKind::kStereo) {}

  /// As in FeatureStream.
  bool skips(const Received& received, const FeatureOptions& options) { return stream_.skips(received, options); }
  /// True until points are found on their rows of the right image. Its keypoints tell where they are, or why not.
  bool needsKeypoints() const { return found_ <= kFewOnRows * tried_; }
  /// No message without a right image; the tracks go on with the next one.
  std::optional<StereoFeatures> next(const ProcessedFrame& processed, const FeatureOptions& options);
  void reset();

 private:
  struct RightPoint {
    Eigen::Vector2d ray;  ///< x, y at depth 1 in the right camera
    double disparity;     ///< of the rectified rays
  };
  static constexpr double kFewOnRows = 0.3;
  std::optional<RightPoint> locate(const PreparedFrame& current, const TrackedPoint& point,
                                   const MatchResult& result) const;

  FeatureStream stream_;
  std::unordered_map<uint32_t, RightPoint> right_;  ///< of the last message, by id
  int tried_ = 0, found_ = 0;                       ///< points of the last message
};

}  // namespace gms_ransac
