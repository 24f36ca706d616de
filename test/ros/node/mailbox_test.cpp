// The queue between two threads: bounded, in order, drops counted.
#include "node/mailbox.h"

#include <thread>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

TEST(Mailbox, KeepsTheLatestAlone) {
  Mailbox<int> box(1);
  EXPECT_EQ(box.push(1), 0);
  EXPECT_EQ(box.push(2), 1);
  int item = 0;
  ASSERT_TRUE(box.pop(item));
  EXPECT_EQ(item, 2);
  EXPECT_EQ(box.clear(), 0);
}

TEST(Mailbox, BeyondItsCapacityTheOldestGoes) {
  Mailbox<int> box(10);
  int dropped = 0;
  for (int i = 0; i < 1000; ++i) dropped += box.push(i);
  EXPECT_EQ(dropped, 990);
  for (int i = 990; i < 1000; ++i) {
    int item = 0;
    ASSERT_TRUE(box.pop(item));
    EXPECT_EQ(item, i);
  }
  EXPECT_EQ(box.clear(), 0);
}

TEST(Mailbox, NobodyWaitsOnceItIsClosed) {
  Mailbox<int> box(1);
  box.push(1);
  std::thread waits([&] { EXPECT_FALSE(box.pushWhenEmpty(2)); });
  box.close();
  waits.join();
  int item = 0;
  EXPECT_FALSE(box.pop(item));
}

}  // namespace
}  // namespace gms_ransac
