// Selects the features that ~features sends, and limits the rate of messages; tracks span the images between them.
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "stream/processed_frame.h"
#include "tracks/track_follower.h"
#include "tracks/track_selector.h"

namespace gms_ransac {

struct FeatureOptions {
  TrackSelectorOptions selection;
  double rate = 10;  ///< messages a second at most; 0: one for every image
};

struct Feature {
  uint32_t id = 0;      ///< that of ~correspondences when it was first sent
  cv::Point2f pixel;    ///< of the received image
  Eigen::Vector2d ray;  ///< x, y at depth 1
  /// Of the ray since the last message, or since the pair's reference, 1/s; zero where that time is not known.
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  double age = 0;  ///< seconds since it was first sent
};

/// Takes the answers to all images, one after another. It costs nothing before the first call.
class FeatureStream {
 public:
  explicit FeatureStream(InputKind input) : input_(input) {}

  /// Returns true if the image, which has not been compared yet, can be skipped: no message is due with it, the
  /// features were well seen the last time, and the next image comes soon enough.
  bool skips(const Received& received, const FeatureOptions& options);

  /// Features to send with this image, in order of preference; empty: no message is due, or nothing can be sent. The
  /// track of a feature that is not `usable` ends.
  std::optional<std::vector<Feature>> next(const ProcessedFrame& processed, const FeatureOptions& options,
                                           const TrackSelector::Usable& usable = {});
  /// Nothing is followed any more.
  void reset();

 private:
  struct Sent {
    Eigen::Vector2d ray;
    double first_stamp;
  };

  /// True if a message is due with an image of this stamp.
  bool due(double stamp, double rate) const;
  /// The inliers that carry an id, with their pixels in the current image.
  const std::vector<TrackedPoint>& matchedPoints(const ProcessedFrame& processed);
  Feature describe(const ProcessedFrame& processed, const TrackedPoint& point) const;
  Eigen::Vector2d velocityInPair(const ProcessedFrame& processed, int row, const Eigen::Vector2d& ray) const;

  const InputKind input_;
  TrackFollower follower_;
  TrackSelector selector_;
  std::vector<TrackedPoint> matched_;
  std::unordered_map<uint32_t, Sent> sent_;  ///< with the last message
  std::optional<double> beat_;               ///< stamp at which the last message was due
  double last_stamp_ = 0;                    ///< of the last message
  double compared_stamp_ = 0;                ///< of the last image that was compared
  double image_stamp_ = 0;                   ///< of the last image, passed over or not
  bool well_seen_ = false;                   ///< the image compared last showed what the one before it did
};

}  // namespace gms_ransac
