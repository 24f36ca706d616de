// The threads that stages share: every task is done once, with any number of callers at the same time.
#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "support/worker_pool.h"

namespace gms_ransac {
namespace {

TEST(WorkerPool, DoesEverythingOnce) {
  const auto pool = WorkerPool::shared(3);
  for (const int count : {0, 1, 2, 7, 1000}) {
    for (const int threads : {1, 2, 4, 9}) {
      std::vector<std::atomic<int>> done(count);
      pool->forEach(count, threads, [&](int i, int) { ++done[i]; });
      EXPECT_TRUE(std::all_of(done.begin(), done.end(), [](int times) { return times == 1; }))
          << count << ' ' << threads;
    }
  }
}

// Data of a thread needs no lock.
TEST(WorkerPool, GivesASeatToOneThreadAtATime) {
  constexpr int kSeats = 4;
  const auto pool = WorkerPool::shared(kSeats - 1);
  for (int round = 0; round < 200; ++round) {
    std::thread::id owner[kSeats];
    std::atomic<int> strangers{0};
    pool->forEach(50, kSeats, [&](int, int thread) {
      if (owner[thread] == std::thread::id()) owner[thread] = std::this_thread::get_id();
      strangers += owner[thread] != std::this_thread::get_id();
    });
    EXPECT_EQ(0, strangers);
    // The caller has the first thread, unless the others did everything before.
    if (owner[0] != std::thread::id()) {
      EXPECT_EQ(std::this_thread::get_id(), owner[0]);
    }
  }
}

// A task that waits for another thread to take part hangs unless one does.
TEST(WorkerPool, Helps) {
  const auto pool = WorkerPool::shared(1);
  std::atomic<int> present{0};
  pool->forEach(2, 2, [&](int, int) {
    ++present;
    while (present < 2) std::this_thread::yield();
  });
  EXPECT_EQ(2, present);
}

TEST(WorkerPool, ServesSeveralOwners) {
  constexpr int kOwners = 4, kRounds = 500, kCount = 20;
  const auto pool = WorkerPool::shared(2);
  std::atomic<int> done{0};
  std::vector<std::thread> owners;
  for (int owner = 0; owner < kOwners; ++owner) {
    owners.emplace_back([&] {
      for (int round = 0; round < kRounds; ++round) pool->forEach(kCount, 3, [&](int, int) { ++done; });
    });
  }
  for (std::thread& owner : owners) owner.join();
  EXPECT_EQ(kOwners * kRounds * kCount, done);
}

TEST(WorkerPool, IsOneWhileSomebodyHoldsIt) {
  std::shared_ptr<WorkerPool> first = WorkerPool::shared(1);
  EXPECT_EQ(first, WorkerPool::shared(2));
  const std::weak_ptr<WorkerPool> watched = first;
  first.reset();
  EXPECT_TRUE(watched.expired());
}

}  // namespace
}  // namespace gms_ransac
