// Stamps and clocks that jump.
#include "stamp_watch.h"

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

constexpr double kGap = 1.0;

TEST(StampWatch, OrdinaryStream) {
  StampWatch watch;
  EXPECT_EQ(watch.judge(10.0, 10.05, kGap), StampVerdict::kFirst);
  EXPECT_EQ(watch.judge(10.1, 10.15, kGap), StampVerdict::kInOrder);
  EXPECT_EQ(watch.judge(11.1, 11.15, kGap), StampVerdict::kInOrder);
}

TEST(StampWatch, LateImagesAreDroppedWithoutMovingTheWatch) {
  StampWatch watch;
  watch.judge(10.0, 10.05, kGap);
  watch.judge(10.2, 10.25, kGap);
  EXPECT_EQ(watch.judge(10.1, 10.26, kGap), StampVerdict::kOutOfOrder);
  EXPECT_EQ(watch.judge(10.2, 10.27, kGap), StampVerdict::kOutOfOrder) << "the same stamp twice";
  EXPECT_EQ(watch.judge(10.3, 10.35, kGap), StampVerdict::kInOrder);
}

TEST(StampWatch, Gap) {
  StampWatch watch;
  watch.judge(10.0, 10.05, kGap);
  EXPECT_EQ(watch.judge(11.01, 11.05, kGap), StampVerdict::kGap);
  EXPECT_EQ(watch.judge(11.11, 11.15, kGap), StampVerdict::kInOrder);
}

TEST(StampWatch, BagLoopedUnderWallTime) {
  StampWatch watch;
  watch.judge(100.0, 5000.0, kGap);
  EXPECT_EQ(watch.judge(10.0, 5000.1, kGap), StampVerdict::kJumpedBack);
  EXPECT_EQ(watch.judge(10.1, 5000.2, kGap), StampVerdict::kInOrder);
}

TEST(StampWatch, SimulatedClockRestarted) {
  StampWatch watch;
  watch.judge(100.0, 100.0, kGap);
  EXPECT_EQ(watch.judge(99.9, 99.9, kGap), StampVerdict::kClockReset) << "even a small step, if the clock made it";
  EXPECT_EQ(watch.judge(100.0, 100.0, kGap), StampVerdict::kInOrder);
}

}  // namespace
}  // namespace gms_ransac
