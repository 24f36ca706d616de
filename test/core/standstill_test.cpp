// A camera that stands still, told from one that moves by little, on a grid of matches.
#include "past/standstill.h"

#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

using Flow = std::function<cv::Point2f(const cv::Point2f& from_centre)>;

/// Matches all over an image of 640 x 480 with noise of 0.15 pixels; those of the left `body_share` of it move by three
/// pixels instead and continue no static track. The upper `copied_share` of the second image repeats the first. For
/// each match there are `lost` keypoints in both images that have none.
bool stands(const Flow& flow, double body_share = 0, bool with_past = true, double copied_share = 0, double lost = 0) {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 0.15f);
  MatchResult result;
  Features reference, current;
  Past past;
  PointPairs& pairs = result.pairs;
  pairs.image_reference = pairs.image_current = {640, 480};
  pairs.resize(48 * 64);
  for (int i = 0; i < pairs.size(); ++i) {
    const auto k = static_cast<size_t>(i);
    const cv::Point2f from(static_cast<float>(i % 64 * 10 + 5), static_cast<float>(i / 64 * 10 + 5));
    const bool body = from.x < body_share * 640;
    const cv::Point2f moved = body ? cv::Point2f(3, 0) : flow(from - cv::Point2f(320, 240));
    pairs.x_reference[k] = from.x;
    pairs.y_reference[k] = from.y;
    pairs.x_current[k] = from.x + moved.x + noise(random);
    pairs.y_current[k] = from.y + moved.y + noise(random);
    reference.keypoints.emplace_back(from, 31.f);
    current.keypoints.emplace_back(pairs.x_current[k], pairs.y_current[k], 31.f);
    if (from.y < copied_share * 480) {
      pairs.x_current[k] = from.x;
      pairs.y_current[k] = from.y;
      current.keypoints.back() = reference.keypoints.back();
    }
    result.matches.push_back({i, i, 0, 0});
    past.reference_static.push_back(body ? 0 : 1);
  }
  const auto all = static_cast<size_t>(pairs.size() * (1 + lost));
  reference.keypoints.resize(all);
  current.keypoints.resize(all);
  return standsStill(reference, current, result, with_past ? &past : nullptr);
}

cv::Point2f rest(const cv::Point2f&) { return {0, 0}; }

TEST(StandsStill, WithNoiseAlone) {
  EXPECT_TRUE(stands(rest));
  EXPECT_TRUE(stands(rest, 0, false));
}

TEST(StandsStill, WhateverCrossesTheView) {
  EXPECT_TRUE(stands(rest, 0.7));
  EXPECT_FALSE(stands(rest, 0.7, false)) << "two views cannot know what is static";
}

TEST(StandsStill, NotWhenAllMovesByLessThanItsNoise) {
  EXPECT_FALSE(stands([](const cv::Point2f&) { return cv::Point2f(0.3f, 0); })) << "turns";
  EXPECT_FALSE(stands([](const cv::Point2f& p) { return cv::Point2f(-p.y, p.x) * (0.3f / 400); })) << "rolls";
  EXPECT_FALSE(stands([](const cv::Point2f& p) { return p * (0.3f / 400); })) << "drives";
}

TEST(StandsStill, NotWhenAFifthOfWhatWasStaticMoves) {
  EXPECT_FALSE(stands([](const cv::Point2f& p) { return cv::Point2f(p.y > 144 ? 2.f : 0.f, 0); }));
}

TEST(StandsStill, ByWhatWasMeasuredTwiceAlone) {
  EXPECT_FALSE(stands(rest, 0, true, 1)) << "the same image twice";
  EXPECT_FALSE(stands([](const cv::Point2f&) { return cv::Point2f(2, 0); }, 0, true, 0.95)) << "the rest moves";
  EXPECT_TRUE(stands(rest, 0, true, 0.5)) << "half of the rows are stuck, the others show it";
}

TEST(StandsStill, NotByThePatternOfTheSensorInTheDark) {
  EXPECT_TRUE(stands(rest, 0, true, 0, 0.5));
  EXPECT_FALSE(stands(rest, 0, true, 0, 1)) << "half of what was seen has moved away or changed";
}

TEST(StandsStill, NotWithoutMatches) { EXPECT_FALSE(standsStill(Features(), Features(), MatchResult(), nullptr)); }

}  // namespace
}  // namespace gms_ransac
