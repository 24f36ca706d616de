#include "program.h"

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <set>
#include <utility>

#include <sys/wait.h>
#include <unistd.h>

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;

constexpr int kBarWidth = 30;  // characters

volatile std::sig_atomic_t noted_interrupt = 0;
void noteInterrupt(int) { noted_interrupt = 1; }

/// Beside this program once installed; in scripts/ of the source when run from a build.
std::string findScript(const std::string& name) {
  std::error_code none;
  const fs::path here = fs::read_symlink("/proc/self/exe", none).parent_path();
  for (const fs::path& candidate : {here / name, fs::path(GMS_RANSAC_SOURCE_DIR) / "scripts" / name}) {
    if (fs::exists(candidate)) return candidate.string();
  }
  return "";
}

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

InterruptWatch::InterruptWatch() : previous_(std::signal(SIGINT, noteInterrupt)) {}

InterruptWatch::~InterruptWatch() { std::signal(SIGINT, previous_); }

bool InterruptWatch::interrupted() { return noted_interrupt != 0; }

int statusOrInterrupted(int status) {
  if (!InterruptWatch::interrupted()) return status;
  std::fputs("interrupted; go on with the same command and --resume\n", stderr);
  return kInterrupted;
}

bool runScript(const std::string& name, const std::string& argument, const std::string& without) {
  const std::string script = findScript(name);
  if (script.empty()) {
    std::fprintf(stderr, "%s: %s is not installed beside this program\n", without.c_str(), name.c_str());
    return false;
  }
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    execl(script.c_str(), script.c_str(), argument.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  if (child >= 0 && waitpid(child, &status, 0) >= 0 && status == 0) return true;
  std::fprintf(stderr, "%s: %s failed\n", without.c_str(), script.c_str());
  return false;
}

void plotTables(const std::string& folder_or_sweep) {
  runScript("plot_tables.py", folder_or_sweep, "no plots, but the tables are complete");
}

}  // namespace gms_ransac
