// The example that finds loops, once round the room: it finds the way back to the start, and nothing that is none.
#include "keyframe_store.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "gms_ransac/match_filter.h"
#include "scenes/scene.h"

namespace gms_ransac {
namespace {

TEST(KeyframeStore, FindsTheLoopOfTheRoomAndNoOther) {
  SceneOptions options;
  options.step = 0.6;
  const Scene room(options);
  constexpr int kRound = 38, kFrames = kRound + 6;  // 22.6 m
  MatchFilter filter;
  KeyframeStore store;
  int found = 0;
  for (int i = 0; i < kFrames; ++i) {
    Frame frame;
    filter.extract(room.render(i).image, frame);
    if (const auto loop = store.findLoop(frame.features)) {
      const Eigen::Isometry3d motion = room.pose(static_cast<int>(loop->keyframe)).inverse() * room.pose(i);
      const double degrees = Eigen::AngleAxisd(motion.linear()).angle() * 180 / CV_PI;
      SCOPED_TRACE(std::to_string(i) + " shows " + std::to_string(loop->keyframe) + " by " +
                   std::to_string(loop->matches.size()));
      EXPECT_LT(motion.translation().norm(), 2);
      EXPECT_LT(degrees, 30) << "another view";
      found += i >= kRound;
    }
    store.add(std::move(frame.features), {});
  }
  EXPECT_GE(found, 4);
}

TEST(KeyframeStore, AViewIsNewWhenHalfOfItsTracksAreGone) {
  KeyframeStore store;
  EXPECT_TRUE(store.isNewView({}));
  store.add(Features(), {0, 7, 3, 0, 5, 9});
  EXPECT_FALSE(store.isNewView({3, 5, 7, 0, 11}));
  EXPECT_TRUE(store.isNewView({3, 5, 0, 11}));
  EXPECT_TRUE(store.isNewView({}));
}

}  // namespace
}  // namespace gms_ransac
