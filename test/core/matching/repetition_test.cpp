// A floor of equal tiles, seen by a camera that moves a part of a tile, and the same floor where no tile is like
// another.
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/status_text.h"
#include "matching/repetition.h"
#include "says.h"

namespace gms_ransac {
namespace {

constexpr double kFocalLength = 500, kTile = 124;  ///< pixels; the floor is at a focal length
const cv::Size kImage(640, 480);

/// A floor of 4000 x 4000 pixels.
cv::Mat floorOf(const cv::Size& tile) {
  cv::RNG random(3);
  cv::Mat stones(tile / 4, CV_8UC1), floor;
  random.fill(stones, cv::RNG::UNIFORM, 0, 255);
  const int across = 4000 / tile.width, down = 4000 / tile.height;
  cv::repeat(stones, down, across, floor);
  cv::resize(floor, floor, cv::Size(), 4, 4, cv::INTER_CUBIC);
  return floor;
}

/// The floor from above by a camera that has moved towards the lower edge of its image, by `moved` pixels of the floor,
/// and looks ahead by some degrees.
cv::Mat seen(const cv::Mat& floor, double moved, uint64_t seed) {
  const double ahead = 0.15;  // of a focal length, at its lower and upper edge
  const std::vector<cv::Point2f> corners = {{0, 0}, {640, 0}, {640, 480}, {0, 480}};
  const auto at = [&](double x, double y) {
    const double depth = 1 / (1 + ahead * (y - 240) / kFocalLength);
    return cv::Point2f(static_cast<float>(2000 + (x - 320) * depth),
                       static_cast<float>(2000 + moved + (y - 240) * depth));
  };
  const std::vector<cv::Point2f> on_floor = {at(0, 0), at(640, 0), at(640, 480), at(0, 480)};
  cv::Mat image, noise(kImage, CV_16SC1);
  cv::warpPerspective(floor, image, cv::getPerspectiveTransform(on_floor, corners), kImage, cv::INTER_LINEAR);
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::add(image, noise, image, cv::noArray(), CV_8UC1);
  return image;
}

MatchResult resultOf(const cv::Mat& floor, double moved) {
  MatchFilter filter;
  filter.setCamera(Camera({kFocalLength, kFocalLength, 320, 240, "", {}}, kImage));
  filter.process(seen(floor, 0, 1));
  return filter.process(seen(floor, moved, 2));
}

TEST(Repetition, EqualTilesDoNotTellWhereTheCameraMoves) {
  const cv::Mat floor = floorOf({124, 124});
  int found = 0;
  for (const double share : {0.2, 0.4, 0.6, 0.8}) {
    const MatchResult result = resultOf(floor, share * kTile);
    EXPECT_NE(result.status, Status::kOk) << share;
    EXPECT_TRUE(result.status == Status::kMotionUnknown ||
                result.robust.judgement.pose.covariance.diagonal().tail<3>().minCoeff() > 0.01)
        << "a tile is 14 degrees wide";
    found += result.robust.judgement.doubt == DirectionDoubt::kRepetition &&
             says(explain(result.status, result, {}, {}), {"repeats itself"});
  }
  EXPECT_GE(found, 2) << "elsewhere matches contradict the motion more";
}

TEST(Repetition, StonesOfWhichNoneIsLikeAnotherDo) {
  const cv::Mat floor = floorOf({4000, 4000});
  for (const double share : {0.2, 0.8}) EXPECT_EQ(resultOf(floor, share * kTile).status, Status::kOk) << share;
}

TEST(Repetition, FewMatchesAreAllLookedAt) {
  constexpr int kMatches = 24, kPeriod = 60;
  Features reference, current;
  reference.image_size = current.image_size = kImage;
  std::vector<Match> matches;
  for (int i = 0; i < kMatches; ++i) {
    const bool repeats = i % 4 != 0;
    matches.push_back({i, i, 20, static_cast<uint16_t>(repeats ? 20 : 120)});
    reference.keypoints.emplace_back(static_cast<float>(100 + i % 6 * 60), static_cast<float>(100 + i / 6 * 60), 31.f);
  }
  cv::Mat descriptors(kMatches, 32, CV_8UC1), twice;
  cv::RNG(5).fill(descriptors, cv::RNG::UNIFORM, 0, 256);
  current.keypoints = reference.keypoints;
  twice = descriptors.clone();
  for (int i = 0; i < kMatches; ++i) {
    if (i % 4 == 0) continue;  // these are looked at first
    current.keypoints.push_back(reference.keypoints[static_cast<size_t>(i)]);
    current.keypoints.back().pt.y += kPeriod;
    twice.push_back(descriptors.row(i));
  }
  reference.descriptors.assign(descriptors);
  current.descriptors.assign(twice);
  const auto period =
      Repetition(detectSimdLevel()).period(reference, current, matches, std::vector<uint8_t>(kMatches, 1));
  ASSERT_TRUE(period);
  EXPECT_NEAR(*period, kPeriod, 1e-3);
}

}  // namespace
}  // namespace gms_ransac
