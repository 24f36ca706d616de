#include "support/worker_pool.h"

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
  opened_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::grow(int threads) {
  const std::lock_guard<std::mutex> lock(mutex_);
  while (static_cast<int>(threads_.size()) < threads) threads_.emplace_back([this] { serve(); });
}

void WorkerPool::run(Job& job) {
  if (job.threads > 1) {
    const std::lock_guard<std::mutex> lock(mutex_);
    addToOpen(job);
  }
  for (int thread = 1; thread < job.threads; ++thread) opened_.notify_one();
  job.work(0);
  if (job.threads <= 1) return;
  std::unique_lock<std::mutex> lock(mutex_);
  if (job.joined < job.threads) removeFromOpen(job);  // no other thread has joined, and no task remains
  finished_.wait(lock, [&] { return job.helping == 0; });
}

void WorkerPool::serve() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    opened_.wait(lock, [this] { return open_ || stopping_; });
    if (stopping_) return;
    Job& job = *open_;
    const int thread = job.joined++;
    if (job.joined == job.threads) removeFromOpen(job);
    ++job.helping;
    lock.unlock();
    job.work(thread);
    lock.lock();
    if (--job.helping == 0) finished_.notify_all();
  }
}

void WorkerPool::addToOpen(Job& job) {
  Job** end = &open_;
  while (*end) end = &(*end)->following;
  *end = &job;
}

void WorkerPool::removeFromOpen(Job& job) {
  Job** link = &open_;
  while (*link != &job) link = &(*link)->following;
  *link = job.following;
}

}  // namespace gms_ransac
