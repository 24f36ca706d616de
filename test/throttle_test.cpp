// The same sentence once in a while, and bounded memory whatever is said.
#include "throttle.h"

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

TEST(Throttle, RemembersABoundedNumberOfSentences) {
  Throttle throttle;
  // A camera whose calibration changes with every image has a new sentence for each.
  for (int i = 0; i < 2000; ++i) throttle.info("fx is " + std::to_string(i), "fx");
  EXPECT_LE(throttle.size(), 100U);
}

TEST(Throttle, MakesRoomForNewSentencesWhenOldOnesAreDue) {
  Throttle throttle(0);
  for (int i = 0; i < 2000; ++i) throttle.info("fx is " + std::to_string(i), "fx");
  EXPECT_GT(throttle.size(), 0U);
  EXPECT_LE(throttle.size(), 100U);
}

TEST(Throttle, KeepsWhatIsSaidOnce) {
  Throttle throttle(0);
  throttle.warnOnce("once", "once");
  for (int i = 0; i < 2000; ++i) throttle.info(std::to_string(i), "often");
  const size_t before = throttle.size();
  throttle.warnOnce("once", "once");
  EXPECT_EQ(throttle.size(), before);
}

}  // namespace
}  // namespace gms_ransac
