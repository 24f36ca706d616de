// The room support has what is of no image: threads, instruction sets, random numbers, order statistics, checks, the
// time budget. It includes no other room.
//
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

  /// Calls task(i, thread) for every i below `count`, on this thread (number 0) and up to threads - 1 idle ones.
  /// Smaller i begin first. The task must not throw. Allocates nothing.
  template <typename Task>
  void forEach(int count, int threads, const Task& task) {
    Job job;
    job.call = [](const void* of, int i, int thread) { (*static_cast<const Task*>(of))(i, thread); };
    job.task = &task;
    job.count = count;
    job.threads = std::min(threads, count);
    run(job);
  }

 private:
  struct Job {
    void (*call)(const void* task, int i, int thread) = nullptr;
    const void* task = nullptr;
    int count = 0;
    int threads = 1;              ///< at most, with the owner's
    int joined = 1, helping = 0;  ///< threads that have ever worked on it; helpers that still do
    std::atomic<int> next{0};     ///< the least i that nobody has begun
    Job* following = nullptr;     ///< in the list of open jobs

    void work(int thread) {
      for (int i = next++; i < count; i = next++) call(task, i, thread);
    }
  };

  void grow(int threads);
  void run(Job& job);
  void serve();
  void addToOpen(Job& job);
  void removeFromOpen(Job& job);

  std::mutex mutex_;
  std::condition_variable opened_, finished_;
  Job* open_ = nullptr;  ///< jobs that more threads may join, the oldest first
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace gms_ransac
