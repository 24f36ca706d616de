// Shared by the offline programs: command lines, errors as one sentence with exit status 2, progress, a clean end by
// Ctrl-C, and the Python reporter that makes their tables and plots.
#pragma once

#include <time.h>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <boost/program_options.hpp>

#include "datasets/dataset.h"

namespace gms_ransac {

constexpr int kNoReport = 1;       ///< exit status of a command without its tables
constexpr int kBadInput = 2;       ///< exit status
constexpr int kInterrupted = 130;  ///< exit status that a shell reports after Ctrl-C

using Arguments = std::vector<std::string>;

/// An argument without an option name.
struct Positional {
  const char* name;
  int count;  ///< number of words; -1: any
  const boost::program_options::value_semantic* value;
};

/// Parses the arguments into the variables of the options. Returns nothing for --help, and prints `usage` and the
/// options. Throws std::exception with a sentence about a wrong argument.
std::optional<boost::program_options::variables_map> parseCommandLine(
    const Arguments& arguments, const std::string& usage, const boost::program_options::options_description& options,
    const std::vector<Positional>& positional = {});

/// An option whose default, which --help shows, is what the variable holds.
template <typename Value>
auto* withDefault(Value& variable) {
  return boost::program_options::value(&variable)->default_value(variable);
}

/// Adds the options of a data set.
void addDatasetOptions(boost::program_options::options_description& description, DatasetOptions& dataset);

/// Throws std::invalid_argument about the first option with a value below 1.
void requireAtLeastOne(std::initializer_list<std::pair<const char*, int>> options);

/// "a,b", "c" -> a, b, c.
std::vector<std::string> splitAtCommas(const std::vector<std::string>& lists);

/// The whole numbers from 1 on in lists with commas; std::invalid_argument about the option where there is another.
std::vector<int> parsePositives(const std::vector<std::string>& lists, const std::string& option);

/// Runs a program and returns its exit status. An exception becomes "<program>: <sentence>" on stderr and kBadInput.
int runProgram(int argc, char** argv, int (*program)(const Arguments&));

/// The time of a clock of the system (clock_gettime), seconds. That of a thread's processor time is not disturbed by
/// other programs.
double secondsOf(clockid_t clock);

/// From now on Ctrl-C sets a flag and does not end the program.
void watchInterrupts();
bool interrupted();
/// `status`; after Ctrl-C kInterrupted, with `advice` on stderr.
int statusOrInterrupted(int status, const std::string& advice);

/// "<what> 12/60, 8.3 a second, 0:00:06 left (<name of the last one>)" on stderr, at the end and on the way: rewritten
/// every half second on a terminal, else a line every two seconds.
class Progress {
 public:
  Progress(std::string what, int total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void advance(const std::string& name = "");
  /// Ends the program after Ctrl-C.
  void advanceUnlessInterrupted();

 private:
  using Clock = std::chrono::steady_clock;
  void show() const;

  const std::string what_;
  const int total_;
  const bool terminal_;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point shown_ = start_;
  int done_ = 0;
  std::string name_;  ///< of the last one done; empty: it has none
};

/// scripts/evaluate_report.py in a process of its own, which may read records, a line each. Measurements do not depend
/// on it: where the script is missing or fails, a sentence on stderr says so.
class Reporter {
 public:
  /// `arguments`: of the script. `out`: file that receives the records, too; "-": standard output, and the report goes
  /// to stderr; "": none. Throws std::invalid_argument when the file cannot be opened.
  explicit Reporter(const std::vector<std::string>& arguments, const std::string& out = "");
  ~Reporter();
  Reporter(const Reporter&) = delete;
  Reporter& operator=(const Reporter&) = delete;

  /// `record` is on disk when this returns; `reported` is what the script reads of it. Throws std::runtime_error when
  /// it cannot be written.
  void add(const std::string& record, const std::string& reported);
  /// Waits for the report. Returns the exit status: kNoReport if there is none, kBadInput if the arguments are refused.
  int finish();

 private:
  const std::string out_;
  std::ofstream file_;
  std::FILE* pipe_ = nullptr;
};

}  // namespace gms_ransac
