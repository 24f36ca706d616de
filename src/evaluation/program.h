// What every offline program shares: one clear line and exit status 2 for bad input, and a progress line.
#pragma once

#include <functional>
#include <string>

namespace gms_ransac {

constexpr int kBadInput = 2;  ///< exit status

/// Runs `body` and returns its exit status; an exception becomes "<program>: <sentence>" on stderr and kBadInput.
int runProgram(const std::string& program, const std::function<int()>& body);

/// `current`; where `given`, the value of `option`, is an earlier name of it, says so on stderr, once for each name.
std::string currentName(const std::string& option, const std::string& given, const std::string& current);

/// "<what> 12/60" and a bar on stderr: rewritten in place on a terminal, else one line for each tenth of the work.
class Progress {
 public:
  Progress(std::string what, int total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void advance();

 private:
  std::string what_;
  int total_, done_ = 0;
  bool terminal_;
};

}  // namespace gms_ransac
