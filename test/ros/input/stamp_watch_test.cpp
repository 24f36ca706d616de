// Stamps and clocks that jump.
#include "input/stamp_watch.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

constexpr double kGap = 1.0;

TEST(StampWatch, JudgesByStampAndClock) {
  using V = StampVerdict;
  struct Image {
    double stamp, now;
    StampVerdict verdict;
  };
  const struct {
    std::string what;
    std::vector<Image> images;
  } rows[] = {{"in order", {{10, 10.05, V::kFirst}, {10.1, 10.15, V::kInOrder}, {11.1, 11.15, V::kInOrder}}},
              {"late images are dropped without moving the watch",
               {{10, 10.05, V::kFirst},
                {10.2, 10.25, V::kInOrder},
                {10.1, 10.26, V::kOutOfOrder},
                {10.2, 10.27, V::kOutOfOrder},
                {10.3, 10.35, V::kAfterLate},
                {10.4, 10.45, V::kInOrder}}},
              {"the same image twice is no sign of a clock that was set",
               {{10, 10.05, V::kFirst},
                {10, 10.06, V::kOutOfOrder},
                {10.1, 10.15, V::kInOrder},
                {10.1, 10.16, V::kOutOfOrder},
                {10.2, 10.25, V::kInOrder}}},
              {"the camera's clock is set back by less than the gap",
               {{10, 10.05, V::kFirst},
                {10.5, 10.55, V::kInOrder},
                {10.1, 10.65, V::kOutOfOrder},
                {10.2, 10.75, V::kSteppedBack},
                {10.3, 10.85, V::kInOrder}}},
              {"by less than two images: no velocity across it",
               {{10, 10.05, V::kFirst},
                {10.1, 10.15, V::kInOrder},
                {10.05, 10.25, V::kOutOfOrder},
                {10.15, 10.35, V::kAfterLate},
                {10.25, 10.45, V::kInOrder}}},
              {"a gap", {{10, 10.05, V::kFirst}, {11.01, 11.05, V::kGap}, {11.11, 11.15, V::kInOrder}}},
              {"a bag looped under wall time",
               {{100, 5000, V::kFirst}, {10, 5000.1, V::kJumpedBack}, {10.1, 5000.2, V::kInOrder}}},
              {"the simulated clock restarted, even by a small step",
               {{100, 100, V::kFirst}, {99.9, 99.9, V::kClockReset}, {100, 100, V::kInOrder}}},
              {"a clock set back under a stream in order restarts nothing",
               {{100, 100.05, V::kFirst},
                {100.1, 99.9, V::kInOrder},
                {100.2, 100.25, V::kInOrder},
                {100.15, 100.3, V::kOutOfOrder}}}};
  for (const auto& row : rows) {
    StampWatch watch;
    for (const Image& image : row.images) {
      EXPECT_EQ(watch.judge(image.stamp, image.now, kGap), image.verdict) << row.what << ", " << image.stamp;
    }
  }
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

}  // namespace
}  // namespace gms_ransac
