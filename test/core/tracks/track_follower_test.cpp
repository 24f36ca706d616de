// Points that are followed without keypoints, over images whose every displacement is known.
#include "tracks/track_follower.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

constexpr int kImageWidth = 320, kImageHeight = 240;
constexpr float kEdge = 60;         // pixels: points that leave the image do not count
constexpr double kTolerance = 0.2;  // pixels, of the worst point: drawing by interpolation is no better

/// A texture that moves as a whole, by fractions of a pixel.
class Wall {
 public:
  Wall() : texture_(2 * kImageHeight, 2 * kImageWidth, CV_8UC1) {
    cv::RNG(5).fill(texture_, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(texture_, texture_, cv::Size(), 2);
    cv::normalize(texture_, texture_, 0, 255, cv::NORM_MINMAX);
  }

  /// The scene, moved by `shift`.
  cv::Mat draw(const cv::Point2f& shift) const {
    cv::Mat image;
    const cv::Point2f middle(static_cast<float>(kImageWidth) - 0.5F - shift.x,
                             static_cast<float>(kImageHeight) - 0.5F - shift.y);
    cv::getRectSubPix(texture_, {kImageWidth, kImageHeight}, middle, image);
    return image;
  }

 private:
  cv::Mat texture_;
};

/// Ids 1, 2, ... on a grid; the row of each match is its id.
std::vector<TrackedPoint> grid(const cv::Point2f& shift = {}) {
  std::vector<TrackedPoint> points;
  uint32_t id = 0;
  for (float y = kEdge; y <= kImageHeight - kEdge; y += 20) {
    for (float x = kEdge; x <= kImageWidth - kEdge; x += 20) {
      ++id;
      points.push_back({id, 2, cv::Point2f(x, y) + shift, static_cast<int>(id)});
    }
  }
  return points;
}

class TrackFollowerTest : public testing::Test {
 protected:
  /// Follows and keeps everything.
  std::vector<TrackedPoint> see(const cv::Mat& image, const std::vector<TrackedPoint>& matched) {
    const std::vector<TrackedPoint> points = follower_.follow(image, Camera(), matched);
    std::vector<int> all(points.size());
    std::iota(all.begin(), all.end(), 0);
    if (!points.empty()) follower_.keep(all);
    return points;
  }
  static bool has(const std::vector<TrackedPoint>& points, uint32_t id) {
    return std::any_of(points.begin(), points.end(), [&](const TrackedPoint& point) { return point.id == id; });
  }
  static double greatestError(const std::vector<TrackedPoint>& points, const cv::Point2f& shift) {
    const std::vector<TrackedPoint> truth = grid(shift);
    double error = 0;
    for (const TrackedPoint& point : points)
      error = std::max(error, cv::norm(point.current - truth[point.id - 1].current));
    return error;
  }
  /// Every `step`-th id is matched.
  static std::vector<TrackedPoint> some(const cv::Point2f& shift, uint32_t step) {
    std::vector<TrackedPoint> points = grid(shift);
    const auto missed = [&](const TrackedPoint& point) { return point.id % step != 0; };
    points.erase(std::remove_if(points.begin(), points.end(), missed), points.end());
    return points;
  }

  const Wall wall_;
  TrackFollower follower_;
};

TEST_F(TrackFollowerTest, WhatIsNotMatchedIsFollowedOnWithoutDrift) {
  see(wall_.draw({}), grid());
  cv::Point2f shift;
  std::vector<TrackedPoint> points;
  for (int i = 1; i <= 20; ++i) {
    shift = cv::Point2f(2.3F, -1.1F) * static_cast<float>(i);
    points = see(wall_.draw(shift), some(shift, 2));
    EXPECT_GT(points.size(), some(shift, 2).size() + 10);
    for (const TrackedPoint& point : points) {
      EXPECT_EQ(point.row, point.id % 2 == 0 ? static_cast<int>(point.id) : -1);
    }
  }
  EXPECT_GT(points.size(), 0.95 * static_cast<double>(grid().size()));
  EXPECT_LT(greatestError(points, shift), kTolerance);
  EXPECT_EQ(points.front().length, 22);
}

TEST_F(TrackFollowerTest, AKeypointsNoiseDoesNotShow) {
  EXPECT_EQ(see(wall_.draw({}), grid()).size(), grid().size());
  const cv::Point2f shift(3.4F, 1.2F), noise(0.6F, -0.5F);
  const std::vector<TrackedPoint> points = see(wall_.draw(shift), grid(shift + noise));
  EXPECT_EQ(points.size(), grid().size());
  EXPECT_LT(greatestError(points, shift), kTolerance);
}

TEST_F(TrackFollowerTest, NeitherAPairThatFailedNorAnImageThatShowsNothingEndsATrack) {
  see(wall_.draw({}), grid());
  EXPECT_TRUE(see(cv::Mat(kImageHeight, kImageWidth, CV_8UC1, cv::Scalar(5)), {}).empty());
  const cv::Point2f shift(17, -9);
  const std::vector<TrackedPoint> points = see(wall_.draw(shift), {});
  EXPECT_GT(points.size(), 0.9 * static_cast<double>(grid().size()));
  EXPECT_LT(greatestError(points, shift), kTolerance);
}

TEST_F(TrackFollowerTest, WhatIsGivenUpDoesNotComeBack) {
  see(wall_.draw({}), grid());
  cv::Point2f shift(3, 0);
  std::vector<TrackedPoint> matched = grid(shift);
  matched[20].current += cv::Point2f(30, 30);  // a wrong match
  EXPECT_FALSE(has(see(wall_.draw(shift), matched), matched[20].id));
  shift.x = 6;
  EXPECT_FALSE(has(see(wall_.draw(shift), grid(shift)), matched[20].id));
}

TEST_F(TrackFollowerTest, AFollowedPointGetsNoSecondId) {
  see(wall_.draw({}), grid());
  const cv::Point2f shift(3, 1);
  std::vector<TrackedPoint> matched = grid(shift);
  matched[20].id = 1000;  // the keypoint is matched anew, its first id was lost
  const std::vector<TrackedPoint> points = see(wall_.draw(shift), matched);
  EXPECT_FALSE(has(points, 1000));
  EXPECT_TRUE(has(points, 21));
}

TEST_F(TrackFollowerTest, OnlyWhatIsKeptIsFollowed) {
  const std::vector<TrackedPoint> points = follower_.follow(wall_.draw({}), Camera(), grid());
  follower_.keep({3, 7});
  const std::vector<TrackedPoint>& next = follower_.follow(wall_.draw({2, 0}), Camera(), {});
  ASSERT_EQ(next.size(), 2u);
  EXPECT_EQ(next[0].id, points[3].id);
  EXPECT_EQ(next[1].id, points[7].id);
}

TEST_F(TrackFollowerTest, WhatMovesOtherThanTheRestIsGivenUp) {
  // The wall moves to the right. Four squares of it have a motion of their own in addition, and no pair carries their
  // points on. To a moving camera one of them may be a board before the wall.
  const std::pair<cv::Point, cv::Point> squares[] = {
      {{70, 70}, {5, 0}}, {{190, 70}, {0, 5}}, {{70, 130}, {4, 4}}, {{190, 130}, {4, -4}}};
  const cv::Mat start = wall_.draw({});
  see(start, grid());
  const cv::Point shift(4, 0);
  cv::Mat image = wall_.draw(shift);
  std::vector<TrackedPoint> matched = grid(shift);
  for (const auto& [corner, motion] : squares) {
    const cv::Rect square(corner, cv::Size(56, 56));
    start(square).copyTo(image(square + shift + motion));
    const auto inside = [&](const TrackedPoint& point) { return cv::Rect2f(square + shift).contains(point.current); };
    matched.erase(std::remove_if(matched.begin(), matched.end(), inside), matched.end());
  }
  const size_t on_wall = matched.size(), moved = grid().size() - on_wall;
  const size_t followed = see(image, matched).size();
  EXPECT_GT(moved, 20u);
  EXPECT_LE(followed, on_wall + moved / 4);
}

TEST_F(TrackFollowerTest, AnotherImageSizeOrAResetStartsAnew) {
  see(wall_.draw({}), grid());
  EXPECT_TRUE(see(wall_.draw({})(cv::Rect(0, 0, kImageWidth / 2, kImageHeight)).clone(), {}).empty());
  see(wall_.draw({}), grid());
  follower_.reset();
  EXPECT_TRUE(see(wall_.draw({}), {}).empty());
}

}  // namespace
}  // namespace gms_ransac
