#include "program.h"

#include <cstdint>
#include <cstdio>
#include <exception>
#include <set>
#include <utility>

#include <unistd.h>

namespace gms_ransac {

namespace {

constexpr int kBarWidth = 30;  // characters

}  // namespace

int runProgram(const std::string& program, const std::function<int()>& body) {
  try {
    return body();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program.c_str(), error.what());
    return kBadInput;
  }
}

std::string currentName(const std::string& option, const std::string& given, const std::string& current) {
  static std::set<std::string> said;
  if (given != current && said.insert(option + " " + given).second) {
    std::fprintf(stderr, "%s %s is now called %s; the old name still works\n", option.c_str(), given.c_str(),
                 current.c_str());
  }
  return current;
}

Progress::Progress(std::string what, int total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (terminal_ && done_ > 0) std::fputc('\n', stderr);
}

void Progress::advance() {
  ++done_;
  if (terminal_) {
    const std::string bar(static_cast<size_t>(done_ * int64_t{kBarWidth} / total_), '#');
    std::fprintf(stderr, "\r%s [%-*s] %d/%d", what_.c_str(), kBarWidth, bar.c_str(), done_, total_);
    std::fflush(stderr);
  } else if (done_ * 10LL / total_ != (done_ - 1) * 10LL / total_) {
    std::fprintf(stderr, "%s %d/%d\n", what_.c_str(), done_, total_);
  }
}

}  // namespace gms_ransac
