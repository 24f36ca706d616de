#include "output/feature_stream.h"

#include <algorithm>
#include <utility>

#include "gms_ransac/camera.h"

namespace gms_ransac {

namespace {

// Share of the time between two messages by which an image may come early: its stamp is not exact.
constexpr double kEarly = 0.1;
// Images that carry no message are passed over up to so many seconds, and as long as this share of the keypoints are
// inliers (doc/inside/tracks.md).
constexpr double kLongestStep = 0.16;
constexpr double kWellSeen = 0.4;

}  // namespace

bool FeatureStream::skips(const Received& received, const FeatureOptions& options) {
  const ReceivedImage& image = received.image;
  const double stamp = image.stamp(), interval = stamp - std::exchange(image_stamp_, stamp);
  const bool in_order =
      received.problem.empty() && image.reset == Reset::kNone && image.stamp_verdict == StampVerdict::kInOrder;
  if (!in_order || input_ == InputKind::kPair || sent_.empty() || due(stamp, options.rate)) return false;
  return well_seen_ && stamp + interval <= compared_stamp_ + kLongestStep;
}

std::optional<std::vector<Feature>> FeatureStream::next(const ProcessedFrame& processed, const FeatureOptions& options,
                                                        const TrackSelector::Usable& usable) {
  // The images of a pair need not be those of the pair before.
  if (processed.continuity != Continuity::kContinuous || input_ == InputKind::kPair) reset();
  const double stamp = processed.current->stamp();
  compared_stamp_ = image_stamp_ = stamp;
  const MatchResult* result = processed.pair ? &processed.pair->result : nullptr;
  well_seen_ = result != nullptr && result->inliers >= kWellSeen * std::max(result->keypoints_reference, 1);
  if (result == nullptr || !processed.current->image.camera->camera.calibrated() || !due(stamp, options.rate))
    return std::nullopt;
  const Camera& camera = processed.current->image.camera->camera;
  const auto& points = follower_.follow(processed.current->image.grey, camera, matchedPoints(processed));
  if (points.empty()) return std::nullopt;
  const std::vector<int>& picked =
      selector_.select(points, processed.current->frame.features.image_size, options.selection, usable);
  std::vector<Feature> features;
  std::unordered_map<uint32_t, Sent> sent;
  for (const int i : picked) {
    features.push_back(describe(processed, points[i]));
    sent.emplace(points[i].id, Sent{features.back().ray, stamp - features.back().age});
  }
  follower_.keep(picked);
  sent_.swap(sent);
  last_stamp_ = stamp;
  if (options.rate > 0) {
    // On the beat, so that images at 25 Hz give 10 messages a second and not 8; after a pause the beat is a new one.
    const bool late = !beat_ || stamp >= *beat_ + 2 / options.rate;
    beat_ = late ? stamp : *beat_ + 1 / options.rate;
  }
  return features;
}

void FeatureStream::reset() {
  follower_.reset();
  sent_.clear();
  beat_.reset();
  well_seen_ = false;
}

bool FeatureStream::due(double stamp, double rate) const {
  return rate <= 0 || !beat_ || stamp >= *beat_ + (1 - kEarly) / rate;
}

const std::vector<TrackedPoint>& FeatureStream::matchedPoints(const ProcessedFrame& processed) {
  matched_.clear();
  const MatchResult& result = processed.pair->result;
  const std::vector<uint32_t>& ids = processed.pair->track_ids;
  for (size_t row = 0; row < ids.size(); ++row) {
    const uint32_t id = ids[row];
    if (id == 0) continue;
    const cv::Point2f& pixel = processed.current->frame.features.keypoints[result.matches[row].current].pt;
    matched_.push_back({id, processed.pair->track_lengths[row], pixel, static_cast<int>(row)});
  }
  return matched_;
}

Feature FeatureStream::describe(const ProcessedFrame& processed, const TrackedPoint& point) const {
  Feature feature;
  feature.id = point.id;
  feature.pixel = point.current;
  feature.ray = rayOf(processed.current->image.camera->camera, point.current);
  const auto before = sent_.find(point.id);
  if (before == sent_.end()) {
    feature.velocity = velocityInPair(processed, point.row, feature.ray);
    return feature;
  }
  const double stamp = processed.current->stamp();
  if (processed.velocity_known) feature.velocity = (feature.ray - before->second.ray) / (stamp - last_stamp_);
  feature.age = stamp - before->second.first_stamp;
  return feature;
}

Eigen::Vector2d FeatureStream::velocityInPair(const ProcessedFrame& processed, int row,
                                              const Eigen::Vector2d& ray) const {
  const double reference_stamp = processed.pair->reference->stamp(),
               seconds = processed.current->stamp() - reference_stamp;
  // With a reference that is held longer it would be an average; VINS's own tracker gives 0 for new features, too.
  const bool held = !sent_.empty() && reference_stamp < last_stamp_;
  if (row < 0 || held || seconds <= 0 || !processed.velocity_known) return Eigen::Vector2d::Zero();
  const int keypoint = processed.pair->result.matches[row].reference;
  const cv::Point2f& before = processed.pair->reference->frame.features.keypoints[keypoint].pt;
  return (ray - rayOf(processed.current->image.camera->camera, before)) / seconds;
}

}  // namespace gms_ransac
