// What waits between two threads: bounded, in order, counted where it is dropped.
#include "node/mailbox.h"

#include <atomic>
#include <thread>
#include <vector>

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

// The two boxes of the node and their threads, while both are cleared over and over; ended when `count` items came
// through. A thread that waits for ever hangs the test.
void passThrough(int count, size_t capacity) {
  Mailbox<int> first(capacity), second(1);
  std::atomic<int> arrived{0};
  std::atomic<bool> closing{false};
  std::vector<std::thread> threads;
  threads.emplace_back([&] {
    for (int i = 1; !closing; ++i) {
      first.push(i);
      std::this_thread::yield();
    }
  });
  threads.emplace_back([&] {
    int item = 0;
    while (first.pop(item)) second.pushWhenEmpty(item);
  });
  threads.emplace_back([&] {
    int item = 0, last = 0;
    while (second.pop(item)) {
      EXPECT_GT(item, last) << "in order, once";
      last = item;
      ++arrived;
    }
  });
  threads.emplace_back([&] {
    while (!closing) {
      first.clear();
      second.clear();
      std::this_thread::yield();
    }
  });
  while (arrived < count) std::this_thread::yield();
  closing = true;
  first.close();
  second.close();
  for (std::thread& thread : threads) thread.join();
}

TEST(Mailbox, ThreadsGoOnAndEndAtEveryStage) {
  for (int count = 0; count < 40; ++count) passThrough(count, 1 + static_cast<size_t>(count) % 4);
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
