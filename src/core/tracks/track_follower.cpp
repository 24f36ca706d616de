#include "tracks/track_follower.h"

#include <algorithm>
#include <array>
#include <limits>

#include <Eigen/LU>
#include <opencv2/calib3d.hpp>
#include <opencv2/video/tracking.hpp>

namespace gms_ransac {

namespace {

// How far from the prediction a point may be, pixels: by the noise of a keypoint or the relief around it.
constexpr float kKeypointReach = 3, kFlowReach = 6, kPyramidReach = 3;
// Neighbours that say where a point went, and features of an image without which that is not known.
constexpr size_t kNeighbours = 5, kFewFlows = 20;
// Pixels that a point may be off its epipolar line, and points without which there is no telling.
constexpr double kEpipolarDistance = 1, kEpipolarConfidence = 0.99;
constexpr size_t kFewPoints = 15;
// Share of the points below which an image without matches shows nothing.
constexpr double kShowsSomething = 0.2;
// A keypoint so near to a followed point, pixels, is the same one under another id.
constexpr float kSamePoint = 3;
// So near to the border, pixels, no patch is taken: what comes into view is waited for.
constexpr float kMargin = 9;
// Areas of a patch, of the one it was taken from, beyond which it is taken anew.
constexpr float kLeastArea = 0.5F, kGreatestArea = 2;
// Optical flow that reaches over some fifty pixels.
const cv::Size kFlowWindow(21, 21);
constexpr int kFlowLevels = 3;

Eigen::Vector2f toEigen(const cv::Point2f& p) { return {p.x, p.y}; }
cv::Point2f toPoint(const Eigen::Vector2f& p) { return {p.x(), p.y()}; }

float median(std::array<float, kNeighbours>& values) {
  std::sort(values.begin(), values.end());
  return values[kNeighbours / 2];
}

}  // namespace

const std::vector<TrackedPoint>& TrackFollower::follow(const cv::Mat& image, const Camera& camera,
                                                       const std::vector<TrackedPoint>& matched) {
  if (last_.size() != image.size()) reset();
  // A dark or covered image may show nothing; then the next one is processed as if this one had not come.
  std::vector<Track> before;
  if (matched.empty()) before = tracks_;
  predict(matched);
  if (flows_.size() < kFewFlows && !tracks_.empty()) predictByFlow(image);
  locate(image);
  checkMotion(camera);
  const auto alive = std::count_if(tracks_.begin(), tracks_.end(), [](const Track& track) { return track.alive; });
  if (matched.empty() && static_cast<double>(alive) < kShowsSomething * static_cast<double>(tracks_.size())) {
    tracks_.swap(before);
    points_.clear();
    return points_;
  }
  image.copyTo(last_);
  report(matched);
  return points_;
}

void TrackFollower::predict(const std::vector<TrackedPoint>& matched) {
  flows_.clear();
  std::unordered_map<uint32_t, const TrackedPoint*> by_id;
  for (const TrackedPoint& point : matched) {
    by_id.emplace(point.id, &point);
    const auto before = seen_.find(point.id);
    if (before != seen_.end()) flows_.push_back({before->second, point.current - before->second});
  }
  for (Track& track : tracks_) {
    track.last = track.point.current;
    const auto found = by_id.find(track.point.id);
    track.point.row = found != by_id.end() ? found->second->row : -1;
    if (track.point.row >= 0) {
      track.prediction = found->second->current;
      track.reach = kKeypointReach;
    } else if (flows_.size() >= kFewFlows) {
      track.prediction = track.last + flowAround(track.last);
      track.reach = kFlowReach;
    }
  }
}

cv::Point2f TrackFollower::flowAround(const cv::Point2f& pixel) const {
  std::array<std::pair<float, const Flow*>, kNeighbours> nearest;
  nearest.fill({std::numeric_limits<float>::max(), nullptr});
  for (const Flow& flow : flows_) {
    const cv::Point2f d = flow.from - pixel;
    const float distance = d.dot(d);
    if (distance >= nearest.back().first) continue;
    size_t i = kNeighbours - 1;
    for (; i > 0 && nearest[i - 1].first > distance; --i) nearest[i] = nearest[i - 1];
    nearest[i] = {distance, &flow};
  }
  std::array<float, kNeighbours> x, y;
  for (size_t i = 0; i < kNeighbours; ++i) {
    x[i] = nearest[i].second->by.x;
    y[i] = nearest[i].second->by.y;
  }
  return {median(x), median(y)};
}

void TrackFollower::predictByFlow(const cv::Mat& image) {
  std::vector<cv::Point2f> from, to;
  for (const Track& track : tracks_) from.push_back(track.last);
  std::vector<uint8_t> found;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(last_, image, from, to, found, error, kFlowWindow, kFlowLevels);
  for (size_t i = 0; i < tracks_.size(); ++i) {
    if (tracks_[i].point.row >= 0) continue;
    tracks_[i].alive = found[i] != 0;
    tracks_[i].prediction = to[i];
    tracks_[i].reach = kPyramidReach;
  }
}

void TrackFollower::locate(const cv::Mat& image) {
  for (Track& track : tracks_) {
    if (!track.alive) continue;
    PatchPlace guess = track.place;
    guess.centre = toEigen(track.prediction);
    auto place = track.patch.find(image, guess, {track.reach});
    if (!place && track.patch.cut(last_, toEigen(track.last))) {
      // It looks otherwise by now than when it was chosen, but perhaps as in the last image.
      guess.shape.setIdentity();
      place = track.patch.find(image, guess, {track.reach});
    }
    track.alive = place.has_value();
    if (!place) continue;
    track.place = *place;
    track.point.current = toPoint(place->centre);
    const float area = place->shape.determinant();
    if (area < kLeastArea || area > kGreatestArea) {
      track.place.shape.setIdentity();
      track.alive = track.patch.cut(image, place->centre);
    }
  }
}

void TrackFollower::checkMotion(const Camera& camera) {
  std::vector<cv::Point2f> from, to;
  std::vector<Track*> seen;
  for (Track& track : tracks_) {
    if (!track.alive) continue;
    from.push_back(camera.undistort(track.last));
    to.push_back(camera.undistort(track.point.current));
    seen.push_back(&track);
  }
  if (seen.size() < kFewPoints) return;
  std::vector<uint8_t> agrees;
  const cv::Mat F = cv::findFundamentalMat(from, to, cv::FM_RANSAC, kEpipolarDistance, kEpipolarConfidence, agrees);
  for (size_t i = 0; i < agrees.size(); ++i) seen[i]->alive = agrees[i] != 0;
}

void TrackFollower::report(const std::vector<TrackedPoint>& matched) {
  points_.clear();
  std::unordered_set<uint32_t> followed, given_up;
  std::vector<cv::Point2f> rescued;
  for (Track& track : tracks_) {
    (track.alive ? followed : given_up_).insert(track.point.id);
    if (!track.alive) continue;
    ++track.point.length;
    points_.push_back(track.point);
    if (track.point.row < 0) rescued.push_back(track.point.current);
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), [](const Track& track) { return !track.alive; }),
                tracks_.end());
  const cv::Rect2f with_patch(kMargin, kMargin, static_cast<float>(last_.cols) - 2 * kMargin,
                              static_cast<float>(last_.rows) - 2 * kMargin);
  for (const TrackedPoint& point : matched) {
    if (given_up_.count(point.id) > 0) given_up.insert(point.id);
    if (given_up_.count(point.id) > 0 || followed.count(point.id) > 0) continue;
    const bool known = std::any_of(rescued.begin(), rescued.end(), [&](const cv::Point2f& other) {
      const cv::Point2f d = other - point.current;
      return d.dot(d) < kSamePoint * kSamePoint;
    });
    if (!known && with_patch.contains(point.current)) points_.push_back(point);
  }
  // An id that is not matched now never will be again, unless nothing is.
  if (!matched.empty()) given_up_.swap(given_up);
  seen_.clear();
  for (const TrackedPoint& point : points_) seen_.emplace(point.id, point.current);
}

void TrackFollower::keep(const std::vector<int>& picked) {
  std::unordered_map<uint32_t, Track*> before;
  for (Track& track : tracks_) before.emplace(track.point.id, &track);
  std::vector<Track> kept;
  kept.reserve(picked.size());
  for (const int i : picked) {
    const auto known = before.find(points_[i].id);
    if (known != before.end()) {
      kept.push_back(std::move(*known->second));
      before.erase(known);
      continue;
    }
    Track track;
    track.point = points_[i];
    track.place.centre = toEigen(track.point.current);
    if (track.patch.cut(last_, track.place.centre)) {
      kept.push_back(std::move(track));
    } else {
      given_up_.insert(track.point.id);
    }
  }
  for (const auto& entry : before) given_up_.insert(entry.first);
  tracks_.swap(kept);
}

void TrackFollower::reset() {
  last_.release();
  tracks_.clear();
  seen_.clear();
  given_up_.clear();
  flows_.clear();
  points_.clear();
}

}  // namespace gms_ransac
