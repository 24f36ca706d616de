#include "worker_pool.h"

namespace gms_ransac {

std::shared_ptr<WorkerPool> WorkerPool::shared(int threads) {
  static std::mutex mutex;
  static std::weak_ptr<WorkerPool> of_process;
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<WorkerPool> pool = of_process.lock();
  if (!pool) of_process = pool = std::make_shared<WorkerPool>();
  pool->grow(threads);
  return pool;
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  offered_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::grow(int threads) {
  const std::lock_guard<std::mutex> lock(mutex_);
  while (static_cast<int>(threads_.size()) < threads) threads_.emplace_back([this] { serve(); });
}

void WorkerPool::run(Job& job) {
  if (job.seats > 1) {
    const std::lock_guard<std::mutex> lock(mutex_);
    enlist(job);
  }
  for (int seat = 1; seat < job.seats; ++seat) offered_.notify_one();
  job.work(0);
  if (job.seats <= 1) return;
  std::unique_lock<std::mutex> lock(mutex_);
  if (job.taken < job.seats) strike(job);  // no other thread has joined, and no task remains
  returned_.wait(lock, [&] { return job.away == 0; });
}

void WorkerPool::serve() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    offered_.wait(lock, [this] { return open_ || stopping_; });
    if (stopping_) return;
    Job& job = *open_;
    const int seat = job.taken++;
    if (job.taken == job.seats) strike(job);
    ++job.away;
    lock.unlock();
    job.work(seat);
    lock.lock();
    if (--job.away == 0) returned_.notify_all();
  }
}

void WorkerPool::enlist(Job& job) {
  Job** end = &open_;
  while (*end) end = &(*end)->following;
  *end = &job;
}

void WorkerPool::strike(Job& job) {
  Job** link = &open_;
  while (*link != &job) link = &(*link)->following;
  *link = job.following;
}

}  // namespace gms_ransac
