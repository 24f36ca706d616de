// A second thread that waits for work, for stages that split theirs in two: starting a thread each time costs more than
// some of these stages take.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace gms_ransac {

class Worker {
 public:
  Worker() : thread_([this] { serve(); }) {}
  ~Worker() {
    {
      std::lock_guard<std::mutex> lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Hands over one task, which must not throw; `wait` before the next. Both must outlive the task: no copy is made.
  template <typename Task>
  void start(Task& task) {
    {
      std::lock_guard<std::mutex> lock(mutex_);
      task_ = std::ref(task);
      busy_ = true;
    }
    changed_.notify_all();
  }

  /// Returns when the task is done.
  void wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !busy_; });
  }

 private:
  void serve() {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return busy_ || stopping_; });
      if (stopping_) return;
      lock.unlock();
      task_();
      lock.lock();
      busy_ = false;
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> task_;
  bool busy_ = false, stopping_ = false;
  std::thread thread_;  ///< last: it reads the members above
};

}  // namespace gms_ransac
