// Stamps and clocks that jump.
#include "input/stamp_watch.h"

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

TEST(StampWatch, OneRestartALoopWhateverComesFirst) {
  const double length = 60;  // of the bag, seconds
  for (const bool clock_first : {false, true}) {
    for (const bool both : {false, true}) {
      StampWatch watch;
      double now = 0, last = 0;
      int restarts = 0;
      const auto send = [&](double stamp) {
        last = stamp;
        const StampVerdict verdict = watch.judge(stamp, now, kGap);
        EXPECT_NE(verdict, StampVerdict::kOutOfOrder) << "stamp " << stamp << ", clock " << now;
        restarts += verdict == StampVerdict::kClockReset || verdict == StampVerdict::kJumpedBack ? 1 : 0;
      };
      for (int loop = 0; loop < 3; ++loop) {
        const int before = restarts;
        if (loop > 0 && !both && clock_first) {
          now = 0.05;
          send(last + 0.1);  // the old loop's last image, on its way when the clock started again
        }
        if (loop > 0 && !both && !clock_first) send(0);  // the new loop's first image, before its clock
        for (double t = both || clock_first ? 0 : 0.1; t < length; t += 0.1) {
          now = t + 0.05;
          send(t);
        }
        EXPECT_EQ(restarts - before, loop > 0 ? 1 : 0) << clock_first << both;
      }
    }
  }
}

TEST(StampWatch, AClockSetBackUnderAStreamInOrderRestartsNothing) {
  StampWatch watch;
  watch.judge(100.0, 100.05, kGap);
  EXPECT_EQ(watch.judge(100.1, 99.9, kGap), StampVerdict::kInOrder);
  EXPECT_EQ(watch.judge(100.2, 100.25, kGap), StampVerdict::kInOrder);
  EXPECT_EQ(watch.judge(100.15, 100.3, kGap), StampVerdict::kOutOfOrder);
}

}  // namespace
}  // namespace gms_ransac
