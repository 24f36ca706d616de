// Table of the benchmark: times of each row, compared with those of a baseline row.
#pragma once

#include <time.h>
#include <list>
#include <ostream>
#include <string>
#include <vector>

namespace gms_ransac {

/// Times work as BenchmarkOptions::threads says: one thread by its processor time, more by the wall clock.
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

struct BenchmarkRow {
  std::string stage, name;
  std::string baseline;                 ///< name of the row of the same stage that this one is compared with; "": none
  std::vector<double> ms = {};          ///< one for each repetition on each pair
  double kept = 0, correct = 0;         ///< sums over the pairs
  int pairs = 0, pairs_with_truth = 0;  ///< how many pairs are in the sums

  /// Does the work and takes its time, which it returns.
  template <typename Work>
  double time(const StageClock& clock, const Work& work) {
    ms.push_back(clock.milliseconds(work));
    return ms.back();
  }
  void count(int kept_here) {
    kept += kept_here;
    ++pairs;
  }
  void countCorrect(int correct_here) {
    correct += correct_here;
    ++pairs_with_truth;
  }
};

class BenchmarkTable {
 public:
  /// The row of that stage and name; made behind those of its stage when it is new. References stay valid.
  BenchmarkRow& row(const std::string& stage, const std::string& name, const std::string& baseline = "");
  const std::list<BenchmarkRow>& rows() const { return rows_; }
  /// As a Markdown table: median and 95th percentile of the milliseconds, the baseline's median over the own, mean
  /// counts of a pair.
  void print(std::ostream& out);

 private:
  std::list<BenchmarkRow> rows_;
};

}  // namespace gms_ransac
