// Hands items from one thread to another, in order. When the mailbox is full the oldest item is dropped.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <utility>

namespace gms_ransac {

template <typename Item>
class Mailbox {
 public:
  /// `capacity`: items that may wait, at least 1; with 1 the latest alone.
  explicit Mailbox(size_t capacity) : capacity_(capacity) {}

  /// Never blocks. Returns how many waiting items had to go: 0 or 1.
  int push(Item item) {
    int dropped = 0;
    {
      std::lock_guard<std::mutex> lock(mutex_);
      if (items_.size() >= capacity_) {
        items_.pop_front();
        dropped = 1;
      }
      items_.push_back(std::move(item));
    }
    arrived_.notify_one();
    return dropped;
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
    int waiting;
    {
      std::lock_guard<std::mutex> lock(mutex_);
      waiting = static_cast<int>(items_.size());
      items_.clear();
    }
    emptied_.notify_one();
    return waiting;
  }

 private:
  const size_t capacity_;
  std::mutex mutex_;
  std::condition_variable arrived_, emptied_;
  std::deque<Item> items_;
  bool closed_ = false;
};

}  // namespace gms_ransac
