// Hands items from the callback thread to the worker: the latest one only (live), or every one in order (replay).
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <utility>

namespace gms_ransac {

template <typename Item>
class Mailbox {
 public:
  explicit Mailbox(bool latest_only) : latest_only_(latest_only) {}

  /// Never blocks. Returns how many waiting items this one replaced: 0, or 1 when only the latest is kept.
  int push(Item item) {
    int replaced = 0;
    {
      std::lock_guard<std::mutex> lock(mutex_);
      if (latest_only_ && !items_.empty()) {
        items_.pop_front();
        replaced = 1;
      }
      items_.push_back(std::move(item));
    }
    arrived_.notify_one();
    return replaced;
  }

  /// Waits until the box is empty, then pushes; false once it is closed. Keeps one thread from running ahead of
  /// another.
  bool pushWhenEmpty(Item item) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      emptied_.wait(lock, [this] { return closed_ || items_.empty(); });
      if (closed_) return false;
      items_.push_back(std::move(item));
    }
    arrived_.notify_one();
    return true;
  }

  /// Waits for an item; false once the box is closed.
  bool pop(Item& item) {
    std::unique_lock<std::mutex> lock(mutex_);
    arrived_.wait(lock, [this] { return closed_ || !items_.empty(); });
    if (closed_) return false;
    item = std::move(items_.front());
    items_.pop_front();
    if (items_.empty()) emptied_.notify_one();
    return true;
  }

  void close() {
    {
      std::lock_guard<std::mutex> lock(mutex_);
      closed_ = true;
    }
    arrived_.notify_all();
    emptied_.notify_all();
  }

  /// Throws away what is waiting and returns how much that was.
  int clear() {
    std::lock_guard<std::mutex> lock(mutex_);
    const int waiting = static_cast<int>(items_.size());
    items_.clear();
    return waiting;
  }

  int size() const {
    std::lock_guard<std::mutex> lock(mutex_);
    return static_cast<int>(items_.size());
  }

 private:
  const bool latest_only_;
  mutable std::mutex mutex_;
  std::condition_variable arrived_, emptied_;
  std::deque<Item> items_;
  bool closed_ = false;
};

}  // namespace gms_ransac
