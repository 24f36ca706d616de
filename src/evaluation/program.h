// What every offline program shares: one clear line and exit status 2 for bad input, a progress line, an end by Ctrl-C
// that loses nothing, and the scripts that draw.
#pragma once

#include <functional>
#include <string>

namespace gms_ransac {

constexpr int kBadInput = 2;       ///< exit status
constexpr int kInterrupted = 130;  ///< exit status: what a shell reports for a program ended by Ctrl-C

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

/// While it lives, Ctrl-C does not end the program but is noted.
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

/// `status`; after Ctrl-C kInterrupted, with a sentence on stderr about how to go on.
int statusOrInterrupted(int status);

/// Runs an installed Python script (in scripts/ of the source when run from a build) on one argument. A script that is
/// missing or fails costs a line on stderr, which says `without` what the rest is.
bool runScript(const std::string& script, const std::string& argument, const std::string& without);
/// Draws the figures of a folder of tables, or of the CSV file of a sweep.
void plotTables(const std::string& folder_or_sweep);

}  // namespace gms_ransac
