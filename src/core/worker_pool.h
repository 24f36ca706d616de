// Threads that wait for work, for stages that share theirs out: starting a thread each time costs more than some of
// these stages take. One set for the whole process: several cameras in one nodelet manager help themselves from it.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace gms_ransac {

constexpr int kMostThreads = 64;  ///< that a stage may ask for

class WorkerPool {
 public:
  /// The pool of this process, with at least so many threads.
  static std::shared_ptr<WorkerPool> shared(int threads);

  WorkerPool() = default;
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Calls task(i, seat) for every i below `count`, on this thread (seat 0) and up to seats - 1 idle ones. Smaller i
  /// begin first. The task must not throw. Allocates nothing.
  template <typename Task>
  void forEach(int count, int seats, const Task& task) {
    Job job;
    job.call = [](const void* of, int i, int seat) { (*static_cast<const Task*>(of))(i, seat); };
    job.task = &task;
    job.count = count;
    job.seats = std::min(seats, count);
    run(job);
  }

 private:
  struct Job {
    void (*call)(const void* task, int i, int seat) = nullptr;
    const void* task = nullptr;
    int count = 0;
    int seats = 1;             ///< the owner's and those of helpers
    int taken = 1, away = 0;   ///< seats given; helpers that have not come back
    std::atomic<int> next{0};  ///< the least i that nobody has begun
    Job* following = nullptr;  ///< in the list of those with free seats

    void work(int seat) {
      for (int i = next++; i < count; i = next++) call(task, i, seat);
    }
  };

  void grow(int threads);
  void run(Job& job);
  void serve();
  void enlist(Job& job);
  void strike(Job& job);

  std::mutex mutex_;
  std::condition_variable offered_, returned_;
  Job* open_ = nullptr;  ///< jobs with free seats, the oldest first
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace gms_ransac
