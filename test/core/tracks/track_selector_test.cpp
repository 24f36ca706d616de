// The choice of followed features: limit, distance, long tracks first, spread, and ids that never come back.
#include "tracks/track_selector.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

const cv::Size kImage(640, 480);

/// Ids 1, 2, ... at random places; lengths 2 to 9.
std::vector<TrackedPoint> randomPoints(int count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> x(0, 640), y(0, 480);
  std::vector<TrackedPoint> points;
  for (int i = 0; i < count; ++i) {
    points.push_back({static_cast<uint32_t>(i + 1), 2 + static_cast<int>(random() % 8), {x(random), y(random)}});
  }
  return points;
}

double nearest(const std::vector<TrackedPoint>& points, const std::vector<int>& picked, const cv::Point2f& point) {
  double least = 1e9;
  for (const int i : picked) {
    if (points[i].current != point) least = std::min(least, cv::norm(points[i].current - point));
  }
  return least;
}

TEST(TrackSelector, KeepsLimitAndDistance) {
  const std::vector<TrackedPoint> points = randomPoints(2000, 1);
  EXPECT_TRUE(TrackSelector().select({}, kImage, {}).empty());
  for (const TrackSelectorOptions options : {TrackSelectorOptions{}, {300, 15}, {50, 3}, {0, 40}, {0, 0}, {10, 2000}}) {
    TrackSelector selector;
    const std::vector<int> picked = selector.select(points, kImage, options);
    ASSERT_FALSE(picked.empty());
    EXPECT_EQ(std::set<int>(picked.begin(), picked.end()).size(), picked.size());
    EXPECT_TRUE(options.limit == 0 || static_cast<int>(picked.size()) <= options.limit);
    for (const int i : picked) EXPECT_GE(nearest(points, picked, points[i].current), options.distance);
    // Every omission has a reason: the limit is reached, or a picked one is too near.
    if (static_cast<int>(picked.size()) == options.limit) continue;
    for (const TrackedPoint& point : points) {
      const bool in = std::any_of(picked.begin(), picked.end(), [&](int i) { return points[i].id == point.id; });
      EXPECT_TRUE(in || nearest(points, picked, point.current) < options.distance);
    }
  }
}

TEST(TrackSelector, TheLongestTracksComeFirst) {
  const std::vector<TrackedPoint> points = randomPoints(2000, 3);
  TrackSelector selector;
  const std::vector<int> picked = selector.select(points, kImage, {100, 15});
  for (size_t k = 1; k < picked.size(); ++k) EXPECT_GE(points[picked[k - 1]].length, points[picked[k]].length);
  // A longer one is missing only for a picked one that is too near and at least as long.
  const int shortest = points[picked.back()].length;
  for (const TrackedPoint& point : points) {
    EXPECT_TRUE(point.length <= shortest || nearest(points, picked, point.current) < 15);
  }
}

TEST(TrackSelector, OfEqualTracksTheBestSpreadIsTaken) {
  std::vector<TrackedPoint> points = randomPoints(2000, 4);
  for (TrackedPoint& point : points) point.length = 2;
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.current.y < b.current.y; });
  TrackSelector selector;
  const std::vector<int> picked = selector.select(points, kImage, {100, 15});
  ASSERT_EQ(picked.size(), 100u);
  std::map<std::pair<int, int>, int> counts;  // of 4 x 4 parts of the image
  for (const int i : picked)
    ++counts[{static_cast<int>(points[i].current.x / 160), static_cast<int>(points[i].current.y / 120)}];
  EXPECT_EQ(counts.size(), 16u);
  for (const auto& [part, count] : counts) EXPECT_NEAR(count, 100 / 16., 5) << part.first << " " << part.second;
}

TEST(TrackSelector, APickedOneStaysThoughLongerTracksCome) {
  TrackSelector selector;
  const TrackSelectorOptions options{1, 15};
  ASSERT_EQ(selector.select({{1, 2, {100, 100}}}, kImage, options), std::vector<int>{0});
  EXPECT_EQ(selector.select({{7, 9, {300, 300}}, {1, 3, {101, 100}}}, kImage, options), std::vector<int>{1});
}

TEST(TrackSelector, OneThatGaveWayIsNotPickedAgain) {
  TrackSelector selector;
  const TrackSelectorOptions options{10, 15};
  ASSERT_EQ(selector.select({{1, 5, {100, 100}}, {2, 3, {120, 100}}}, kImage, options).size(), 2u);
  EXPECT_EQ(selector.select({{1, 6, {100, 100}}, {2, 4, {110, 100}}}, kImage, options), std::vector<int>{0});
  EXPECT_EQ(selector.select({{1, 7, {100, 100}}, {2, 5, {140, 100}}}, kImage, options), std::vector<int>{0});
  EXPECT_EQ(selector.select({{2, 6, {140, 100}}, {3, 2, {300, 100}}}, kImage, options), std::vector<int>{1});
}

}  // namespace
}  // namespace gms_ransac
