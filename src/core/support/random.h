// A small generator whose numbers are the same on every platform; the standard library's distributions are not.
#pragma once

#include <cstdint>

namespace gms_ransac {

/// SplitMix64 (Steele, Lea & Flood, OOPSLA 2014): a counter and a mixing function, so any seed is a good one.
class Random {
 public:
  explicit Random(uint64_t seed = 0) : state_(seed) {}

  uint64_t next() {
    state_ += 0x9E3779B97F4A7C15ull;
    uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }

  /// An index in [0, n); n > 0. The bias of the multiply-shift is below n / 2^32.
  int below(int n) { return static_cast<int>(((next() >> 32) * static_cast<uint64_t>(n)) >> 32); }

  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

 private:
  uint64_t state_;
};

/// `count` distinct indices in [0, n), in random order; needs n >= count.
inline void drawDistinct(Random& random, int n, int count, int* indices) {
  for (int i = 0; i < count; ++i) {
    bool repeated = true;
    while (repeated) {
      indices[i] = random.below(n);
      repeated = false;
      for (int j = 0; j < i; ++j) repeated |= indices[j] == indices[i];
    }
  }
}

}  // namespace gms_ransac
