// Ids of followed features against a naive record of every track.
#include "tracks/track_table.h"

#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

MatchResult pairOf(int reference, int current, const std::vector<Match>& inliers) {
  MatchResult result;
  result.keypoints_reference = reference;
  result.keypoints_current = current;
  result.matches = inliers;
  result.stage.assign(inliers.size(), MatchStage::kInlier);
  return result;
}

TEST(TrackTable, RejectedMatchesCarryNothingOn) {
  TrackTable table;
  MatchResult result = pairOf(3, 3, {{0, 0, 10, 90}, {1, 1, 10, 90}});
  result.stage[1] = MatchStage::kGms;
  table.link(result);
  EXPECT_EQ(table.ids()[1], 0u);
  EXPECT_EQ(table.lengths()[1], 0);
}

TEST(TrackTable, TheBetterOfTwoOnOneKeypointKeepsIt) {
  TrackTable table;
  table.link(pairOf(3, 3, {{0, 1, 30, 90}, {1, 1, 20, 90}, {2, 1, 20, 90}}));
  EXPECT_EQ(table.ids()[0], 0u);
  EXPECT_NE(table.ids()[1], 0u);
  EXPECT_EQ(table.ids()[2], 0u);
}

TEST(TrackTable, AHeldReferenceKeepsItsIds) {
  TrackTable table;
  table.link(pairOf(3, 3, {{0, 1, 30, 90}}));
  const uint32_t id = table.ids()[0];
  table.link(pairOf(3, 3, {{0, 2, 30, 90}}));  // the same reference with the next image
  EXPECT_EQ(table.ids()[0], id);
  table.advance();
  table.link(pairOf(3, 3, {{2, 0, 30, 90}}));
  EXPECT_EQ(table.ids()[0], id);
}

TEST(TrackTable, AnIdThatOneImageMissedDoesNotComeBack) {
  TrackTable table;
  table.link(pairOf(3, 3, {{0, 1, 30, 90}, {1, 0, 30, 90}}));
  const uint32_t missed = table.ids()[0], kept = table.ids()[1];
  table.link(pairOf(3, 3, {{1, 0, 30, 90}}));
  table.link(pairOf(3, 3, {{0, 1, 30, 90}, {1, 0, 30, 90}}));
  EXPECT_GT(table.ids()[0], kept);
  EXPECT_NE(table.ids()[0], missed);
  EXPECT_EQ(table.ids()[1], kept);
  EXPECT_EQ(table.lengths(), (std::vector<uint16_t>{2, 4}));
}

TEST(TrackTable, AnImageThatShowsNothingEndsNoTrack) {
  TrackTable table;
  table.link(pairOf(3, 3, {{0, 1, 30, 90}}));
  const uint32_t id = table.ids()[0];
  table.link(pairOf(3, 3, {}));
  table.link(pairOf(3, 3, {{0, 1, 30, 90}}));
  EXPECT_EQ(table.ids()[0], id);
}

TEST(TrackTable, AfterAResetNoIdComesBack) {
  TrackTable table;
  table.link(pairOf(2, 2, {{0, 0, 1, 2}, {1, 1, 1, 2}}));
  const std::set<uint32_t> before(table.ids().begin(), table.ids().end());
  table.advance();
  table.reset();
  EXPECT_TRUE(table.ids().empty());
  table.link(pairOf(2, 2, {{0, 0, 1, 2}, {1, 1, 1, 2}}));
  for (uint32_t id : table.ids()) EXPECT_EQ(before.count(id), 0u);
}

TEST(TrackTable, GoingBackTracksGoOnThatNoImageHasMissed) {
  TrackTable table;
  table.link(pairOf(4, 4, {{0, 0, 10, 90}, {1, 1, 10, 90}}));
  const uint32_t stays = table.ids()[0], ends = table.ids()[1];
  table.advance();
  const auto earlier = table.tracks();
  table.link(pairOf(4, 4, {{0, 2, 10, 90}}));  // the image after: `ends` is not seen in it
  EXPECT_EQ(table.ids()[0], stays);
  table.advance();
  const auto newest = table.tracks();
  table.link(pairOf(4, 9, {}));  // lost
  table.advance();
  table.goBack(earlier, newest);
  const MatchResult again = pairOf(4, 4, {{0, 3, 10, 90}, {1, 1, 10, 90}});
  table.link(again);
  EXPECT_EQ(table.ids()[0], stays);
  EXPECT_NE(table.ids()[1], ends) << "an image has missed it";
  table.goBack(earlier, newest);
  table.link(again);
  EXPECT_NE(table.ids()[0], stays) << "another link has found something";
}

TEST(TrackTable, AgreesWithANaiveRecordOnRandomSequences) {
  std::mt19937 random(3);
  TrackTable table;
  std::map<int, uint32_t> id_of;  // keypoint of the reference -> id
  std::map<uint32_t, int> seen;
  std::set<uint32_t> ever;
  for (int frame = 0; frame < 200; ++frame) {
    std::vector<int> targets(40);
    for (int i = 0; i < 40; ++i) targets[i] = i;
    std::shuffle(targets.begin(), targets.end(), random);
    std::vector<Match> matches;
    for (int i = 0; i < 40; ++i) {
      if (random() % 3) matches.push_back({i, targets[i], static_cast<uint16_t>(random() % 50), 60});
    }
    table.link(pairOf(40, 40, matches));
    std::map<int, uint32_t> next;
    std::set<uint32_t> in_image;
    for (size_t m = 0; m < matches.size(); ++m) {
      const uint32_t id = table.ids()[m];
      EXPECT_TRUE(in_image.insert(id).second);
      const auto known = id_of.find(matches[m].reference);
      if (known != id_of.end()) {
        EXPECT_EQ(id, known->second);
        ++seen[id];
      } else {
        EXPECT_TRUE(ever.insert(id).second) << "an id was used again";
        seen[id] = 2;
      }
      EXPECT_EQ(table.lengths()[m], seen[id]);
      next[matches[m].current] = id;
    }
    id_of = next;
    table.advance();
  }
}

}  // namespace
}  // namespace gms_ransac
