// The matrix "matches from left cell l to right cell r" of one grid at a time. It is never cleared: every entry carries
// the generation it was written in, and an older one counts as zero, so that a grid costs only the entries it touches.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

namespace gms_ransac {

class VoteMatrix {
 public:
  /// Starts an all-zero matrix of `rows` x `columns` that can count up to `matches` in each entry.
  void begin(int rows, int columns, int matches) {
    columns_ = columns;
    const size_t size = static_cast<size_t>(rows) * columns;
    while (matches >> count_bits_) {
      ++count_bits_;
      capacity_ = 0;
    }
    const uint32_t step = 1u << count_bits_;
    if (size > capacity_ || generation_ > UINT32_MAX - 2 * step) {
      // calloc: of a large matrix the pages that no match falls into are never touched, nor taken from the system.
      capacity_ = std::max(size, capacity_);
      entries_.reset(static_cast<uint32_t*>(std::calloc(capacity_, sizeof(uint32_t))));
      if (!entries_) throw std::bad_alloc();
      generation_ = 0;
    }
    generation_ += step;
  }

  uint32_t* row(int row) { return entries_.get() + static_cast<size_t>(row) * columns_; }
  /// Counts a match; the returned value grows with the count.
  uint32_t increment(uint32_t& entry) const { return entry = std::max(entry, generation_) + 1; }
  int count(uint32_t entry) const { return static_cast<int>(std::max(entry, generation_) - generation_); }

 private:
  struct Free {
    void operator()(uint32_t* entries) const { std::free(entries); }
  };
  std::unique_ptr<uint32_t, Free> entries_;
  size_t capacity_ = 0;
  int columns_ = 0;
  int count_bits_ = 17;  ///< low bits of an entry; a pair of images has fewer matches than 2^17 as a rule
  uint32_t generation_ = 0;
};

}  // namespace gms_ransac
