// Shared by the offline programs: errors as one sentence with exit status 2, progress, a clean end by Ctrl-C, and the
// Python reporter that makes their tables and plots.
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace gms_ransac {

constexpr int kNoReport = 1;       ///< exit status of a command without its tables
constexpr int kBadInput = 2;       ///< exit status
constexpr int kInterrupted = 130;  ///< exit status that a shell reports after Ctrl-C

/// Thrown to end a program after Ctrl-C.
struct Interrupted {};

/// Runs `body` and returns its exit status. An exception becomes "<program>: <sentence>" on stderr and kBadInput.
int runProgram(const std::string& program, const std::function<int()>& body);

/// "<what> 12/60, 8.3 a second, 0:00:06 left" on stderr, at the end and on the way: rewritten every half second on a
/// terminal, else a line every two seconds.
class Progress {
 public:
  Progress(std::string what, int total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void advance();

 private:
  using Clock = std::chrono::steady_clock;
  void show() const;

  const std::string what_;
  const int total_;
  const bool terminal_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point shown_ = start_;
  int done_ = 0;
  std::mutex mutex_;
};

/// While it exists, Ctrl-C sets a flag and does not end the program.
class InterruptWatch {
 public:
  InterruptWatch();
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;
  static bool interrupted();

 private:
  void (*previous_)(int);
};

/// `status`; after Ctrl-C kInterrupted, with `advice` on stderr.
int statusOrInterrupted(int status, const std::string& advice);

/// scripts/evaluate_report.py in a process of its own, which may read records, a line each. Measurements do not depend
/// on it: where the script is missing or fails, a sentence on stderr says so.
class Reporter {
 public:
  /// `arguments`: of the script. `to_stderr`: its output goes there.
  explicit Reporter(const std::vector<std::string>& arguments, bool to_stderr = false);
  ~Reporter();
  Reporter(const Reporter&) = delete;
  Reporter& operator=(const Reporter&) = delete;

  void add(const std::string& record);
  /// Waits for the report. Returns false if there is none.
  bool finish();

 private:
  std::FILE* pipe_ = nullptr;
};

}  // namespace gms_ransac
