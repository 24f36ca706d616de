#include "program.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <exception>
#include <filesystem>
#include <utility>

#include <unistd.h>

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

volatile std::sig_atomic_t noted_interrupt = 0;
void noteInterrupt(int) { noted_interrupt = 1; }

/// The script next to this program once installed, in scripts/ of the source when run from a build; "" without it.
std::string findReporter() {
  std::error_code none;
  const fs::path here = fs::read_symlink("/proc/self/exe", none).parent_path();
  for (const fs::path& folder : {here, fs::path(GMS_RANSAC_SOURCE_DIR) / "scripts"}) {
    const fs::path script = folder / "evaluate_report.py";
    if (fs::exists(script)) return script.string();
  }
  return "";
}

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string clockText(double seconds) {
  const long whole = std::lround(seconds);
  char text[32];
  std::snprintf(text, sizeof(text), "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
  return text;
}

}  // namespace

int runProgram(const std::string& program, const std::function<int()>& body) {
  std::signal(SIGPIPE, SIG_IGN);  // a reporter that has ended must not end the measurements
  try {
    return body();
  } catch (const Interrupted&) {
    std::fprintf(stderr, "%s: interrupted\n", program.c_str());
    return kInterrupted;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program.c_str(), error.what());
    return kBadInput;
  }
}

Progress::Progress(std::string what, int total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  show();
  if (terminal_) std::fputc('\n', stderr);
}

void Progress::advance() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++done_;
  const auto now = std::chrono::steady_clock::now();
  if (now - shown_ < (terminal_ ? milliseconds(500) : milliseconds(2000))) return;
  shown_ = now;
  show();
}

void Progress::show() const {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double rate = done_ / std::max(seconds, 1e-3);
  const std::string rest = done_ == 0        ? ""
                           : done_ == total_ ? ", " + clockText(seconds)
                                             : ", " + clockText((total_ - done_) / rate) + " left";
  std::fprintf(stderr, terminal_ ? "\r%s %d/%d, %.1f a second%s\033[K" : "%s %d/%d, %.1f a second%s\n", what_.c_str(),
               done_, total_, rate, rest.c_str());
  std::fflush(stderr);
}

InterruptWatch::InterruptWatch() : previous_(std::signal(SIGINT, noteInterrupt)) {}

InterruptWatch::~InterruptWatch() { std::signal(SIGINT, previous_); }

bool InterruptWatch::interrupted() { return noted_interrupt != 0; }

int statusOrInterrupted(int status, const std::string& advice) {
  if (!InterruptWatch::interrupted()) return status;
  std::fprintf(stderr, "interrupted; %s\n", advice.c_str());
  return kInterrupted;
}

Reporter::Reporter(const std::vector<std::string>& arguments, bool to_stderr) {
  std::string command = quoted(GMS_RANSAC_PYTHON) + ' ' + quoted(findReporter());
  for (const std::string& argument : arguments) command += ' ' + quoted(argument);
  std::fflush(nullptr);
  const auto handler = std::signal(SIGINT, SIG_IGN);  // inherited: Ctrl-C ends the records, and then comes the report
  pipe_ = popen((command + (to_stderr ? " 1>&2" : "")).c_str(), "w");
  std::signal(SIGINT, handler);
}

Reporter::~Reporter() {
  if (pipe_) pclose(pipe_);
}

void Reporter::add(const std::string& record) {
  if (pipe_) std::fprintf(pipe_, "%s\n", record.c_str());
}

bool Reporter::finish() {
  const bool reported = pipe_ && pclose(std::exchange(pipe_, nullptr)) == 0;
  if (!reported)
    std::fputs("no report: evaluate_report.py is missing or failed; the measurements are complete\n", stderr);
  return reported;
}

}  // namespace gms_ransac
