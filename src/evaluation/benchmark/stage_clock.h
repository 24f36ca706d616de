// Times work as BenchmarkOptions::threads says: one thread by its processor time, more by the wall clock.
#pragma once

#include <time.h>

namespace gms_ransac {

class StageClock {
 public:
  explicit StageClock(int threads) : clock_(threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC) {}

  template <typename Work>
  double milliseconds(const Work& work) const {
    const double start = now();
    work();
    return now() - start;
  }

 private:
  double now() const {
    timespec time{};
    clock_gettime(clock_, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
  }
  clockid_t clock_;
};

}  // namespace gms_ransac
