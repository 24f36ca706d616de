// Ids of followed features, over pairs small enough to follow by hand.
#include "tracks/track_table.h"

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

MatchResult pairOf(int reference, int current, const std::vector<Match>& inliers) {
  MatchResult result;
  result.keypoints_reference = reference;
  result.keypoints_current = current;
  result.matches = inliers;
  result.inliers = result.size();
  result.inlier.assign(inliers.size(), 1);
  return result;
}

TEST(TrackTable, RejectedMatchesCarryNothingOn) {
  TrackTable table;
  MatchResult result = pairOf(3, 3, {{0, 0, 10, 90}, {1, 1, 10, 90}});
  result.inlier = {1, 0};
  result.inliers = 1;
  table.link(result);
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{1, 0}));
  EXPECT_EQ(table.lengths(), (std::vector<uint16_t>{2, 0}));
}

TEST(TrackTable, TheBetterOfTwoOnOneKeypointKeepsIt) {
  TrackTable table;
  table.link(pairOf(3, 3, {{0, 1, 30, 90}, {1, 1, 20, 90}, {2, 1, 20, 90}}));
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{0, 1, 0}));
}

TEST(TrackTable, IdsGoOnFromPairToPairAndWhereTheReferenceIsHeld) {
  TrackTable table;
  table.link(pairOf(3, 3, {{0, 0, 30, 90}, {1, 1, 30, 90}}));
  table.link(pairOf(3, 3, {{0, 1, 30, 90}, {1, 2, 30, 90}}));  // the same reference with the next image
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{1, 2}));
  table.advance();
  table.link(pairOf(3, 4, {{0, 3, 30, 90}, {1, 1, 30, 90}, {2, 0, 30, 90}}));
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{3, 1, 2}));
  EXPECT_EQ(table.lengths(), (std::vector<uint16_t>{2, 4, 4}));
  table.advance();
  table.link(pairOf(4, 3, {{3, 0, 30, 90}, {0, 1, 30, 90}, {2, 2, 30, 90}}));
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{3, 2, 4}));
  EXPECT_EQ(table.lengths(), (std::vector<uint16_t>{3, 5, 2}));
}

TEST(TrackTable, AnIdThatOneImageMissedDoesNotComeBack) {
  TrackTable table;
  table.link(pairOf(3, 3, {{0, 1, 30, 90}, {1, 0, 30, 90}}));
  table.link(pairOf(3, 3, {{1, 0, 30, 90}}));
  table.link(pairOf(3, 3, {}));  // an image that shows nothing ends no track
  table.link(pairOf(3, 3, {{0, 1, 30, 90}, {1, 0, 30, 90}}));
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{3, 1}));
  EXPECT_EQ(table.lengths(), (std::vector<uint16_t>{2, 4}));
}

TEST(TrackTable, AfterTheLargestIdComesTheFirstThatNoTrackHas) {
  TrackTable table(4294967293);
  table.link(pairOf(3, 5, {{0, 0, 30, 90}, {1, 1, 30, 90}}));
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{4294967293, 4294967294}));
  table.advance();
  table.link(pairOf(5, 5, {{0, 0, 30, 90}, {2, 2, 30, 90}, {3, 3, 30, 90}, {4, 4, 30, 90}}));
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{4294967293, 4294967295, 1, 2})) << "0 is no id";

  TrackTable living, last(4294967295);
  living.link(pairOf(2, 4, {{0, 0, 30, 90}, {1, 1, 30, 90}}));
  living.advance();
  last.link(pairOf(1, 1, {{0, 0, 30, 90}}));
  living.numberFrom(last);
  living.link(pairOf(4, 4, {{0, 0, 30, 90}, {1, 1, 30, 90}, {2, 2, 30, 90}, {3, 3, 30, 90}}));
  EXPECT_EQ(living.ids(), (std::vector<uint32_t>{1, 2, 3, 4})) << "1 and 2 still go on";
}

TEST(TrackTable, AfterAResetNoIdComesBack) {
  TrackTable table;
  table.link(pairOf(2, 2, {{0, 0, 1, 2}, {1, 1, 1, 2}}));
  table.advance();
  table.reset();
  EXPECT_TRUE(table.ids().empty());
  table.link(pairOf(2, 2, {{0, 0, 1, 2}, {1, 1, 1, 2}}));
  EXPECT_EQ(table.ids(), (std::vector<uint32_t>{3, 4}));
}

TEST(TrackTable, GoingBackTracksGoOnThatNoImageHasMissed) {
  TrackTable table;
  table.link(pairOf(4, 4, {{0, 0, 10, 90}, {1, 1, 10, 90}}));
  const uint32_t stays = table.ids()[0], ends = table.ids()[1];
  table.advance();
  table.link(pairOf(4, 4, {{0, 2, 10, 90}}));  // the image after: `ends` is not seen in it
  EXPECT_EQ(table.ids()[0], stays);
  table.advance();
  const TrackTable newest = table;
  table.link(pairOf(4, 9, {}));  // lost
  table.advance();
  const MatchResult again = pairOf(4, 4, {{2, 3, 10, 90}, {1, 1, 10, 90}});
  TrackTable back = newest;
  back.numberFrom(table);
  back.link(again);
  EXPECT_EQ(back.ids()[0], stays);
  EXPECT_GT(back.ids()[1], ends) << "an image has missed it";
  table.link(pairOf(9, 4, {{5, 1, 10, 90}}));
  const uint32_t other = table.ids()[0];
  back = newest;
  back.numberFrom(table);
  back.link(again);
  EXPECT_GT(back.ids()[0], other) << "another link has found something";
  EXPECT_GT(back.ids()[1], other);
}

}  // namespace
}  // namespace gms_ransac
