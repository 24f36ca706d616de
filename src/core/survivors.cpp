#include "survivors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gms_ransac {

namespace {

bool hasRays(const Features& reference, const Features& current, const Match& match, const Camera& camera) {
  if (!camera.mayLackInverse()) return true;
  const cv::Point2f p = camera.undistort(reference.keypoints[match.reference].pt);
  const cv::Point2f q = camera.undistort(current.keypoints[match.current].pt);
  return !std::isnan(p.x) && !std::isnan(q.x);
}

void describe(const Features& reference, const Features& current, const MotionStatistics& statistics,
              const Camera& camera, const std::vector<int>& kept, MatchResult& result) {
  PointPairs& pairs = result.pairs;
  result.matches.resize(kept.size());
  result.confidence.resize(kept.size());
  result.current_pixel.resize(kept.size());
  pairs.resize(static_cast<int>(kept.size()));
  pairs.image_reference = reference.image_size;
  pairs.image_current = current.image_size;
  pairs.scale_factor = current.scale_factor;
  pairs.aligned.clear();
  int32_t largest = 0;
  for (size_t row = 0; row < kept.size(); ++row) {
    const auto raw = static_cast<size_t>(kept[row]);
    const Match match = result.matches[row] = result.raw[raw];
    const cv::KeyPoint& a = reference.keypoints[match.reference];
    const cv::KeyPoint& b = current.keypoints[match.current];
    const cv::Point2f p = camera.undistort(a.pt), q = camera.undistort(b.pt);
    result.current_pixel[row] = b.pt;
    pairs.x_reference[row] = p.x;
    pairs.y_reference[row] = p.y;
    pairs.x_current[row] = q.x;
    pairs.y_current[row] = q.y;
    pairs.octave_reference[row] = static_cast<uint8_t>(a.octave);
    pairs.octave_current[row] = static_cast<uint8_t>(b.octave);
    pairs.score[row] = statistics.score[raw];
    pairs.relative_score[row] = statistics.relative_score[raw];
    pairs.distance[row] = match.distance;
    pairs.second_distance[row] = match.second_distance;
    largest = std::max(largest, pairs.score[row]);
  }
  for (size_t row = 0; row < kept.size(); ++row) {
    result.confidence[row] = largest > 0 ? static_cast<float>(pairs.score[row]) / static_cast<float>(largest) : 1.f;
  }
}

void describeImageRows(const Features& reference, const Features& current, const Camera& camera, MatchResult& result) {
  PointPairs& pairs = result.pairs;
  pairs.row_reference.clear();
  pairs.row_current.clear();
  if (!camera.distorts()) return;
  for (const Match& match : result.matches) {
    pairs.row_reference.push_back(reference.keypoints[match.reference].pt.y);
    pairs.row_current.push_back(current.keypoints[match.current].pt.y);
  }
}

}  // namespace

void SurvivorSelector::select(const Features& reference, const Features& current, const MotionStatistics& statistics,
                              const Camera& camera, MatchResult& result) {
  kept_.clear();
  for (size_t raw = 0; raw < result.raw.size(); ++raw) {
    if (!statistics.accepted[raw]) continue;
    if (hasRays(reference, current, result.raw[raw], camera)) kept_.push_back(static_cast<int>(raw));
  }
  if (one_to_one_) keepOneForEachPoint(current.keypoints.size(), result.raw, statistics);
  describe(reference, current, statistics, camera, kept_, result);
  if (with_image_rows_) describeImageRows(reference, current, camera, result);
}

void SurvivorSelector::selectAll(const Features& reference, const Features& current, const Camera& camera,
                                 MatchResult& result) {
  MotionStatistics none;
  none.score.assign(result.raw.size(), 0);
  none.relative_score.assign(result.raw.size(), 0);
  kept_.resize(result.raw.size());
  std::iota(kept_.begin(), kept_.end(), 0);
  describe(reference, current, none, camera, kept_, result);
  if (with_image_rows_) describeImageRows(reference, current, camera, result);
}

void SurvivorSelector::keepOneForEachPoint(size_t current_points, const std::vector<Match>& raw,
                                           const MotionStatistics& statistics) {
  // The log-odds of being right include the descriptors; a score alone prefers the fullest cell.
  const std::vector<float>& log_odds = statistics.log_odds;
  const auto better = [&](int a, int b) {
    if (!log_odds.empty() && log_odds[a] != log_odds[b]) return log_odds[a] > log_odds[b];
    return raw[a].distance < raw[b].distance;
  };
  constexpr int kNone = -1;
  best_.assign(current_points, kNone);
  for (const int i : kept_) {
    int& best = best_[raw[i].current];
    if (best == kNone || better(i, best)) best = i;
  }
  const auto beaten = [&](int i) { return best_[raw[i].current] != i; };
  kept_.erase(std::remove_if(kept_.begin(), kept_.end(), beaten), kept_.end());
}

}  // namespace gms_ransac
