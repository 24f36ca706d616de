// The subcommands of `evaluate`, and the command line that they share. A command takes the arguments behind its name
// and returns the exit status; bad input is an exception with one clear sentence.
#pragma once

#include <string>
#include <vector>

#include <boost/program_options.hpp>

#include "gms_ransac/match_filter_options.h"
#include "parameters/parameter.h"
#include "program.h"
#include "run/series.h"

namespace gms_ransac {

int evaluateRun(const Arguments& arguments);
int evaluateOdometry(const Arguments& arguments);
int evaluateSweep(const Arguments& arguments);
int evaluateTables(const Arguments& arguments);
int evaluateTrust(const Arguments& arguments);

/// Options of a command, and those that all have: sets, their calibration, and every parameter of the core
/// (cfg/parameters.py), `foo_bar` as --foo-bar. Values land in this object and in the command's variables.
class CommandLine {
 public:
  explicit CommandLine(std::vector<std::string> report) : report(std::move(report)) {}

  boost::program_options::options_description options;  ///< the command's own; to be filled before parsing
  MatchFilterOptions base;                              ///< the defaults; with --paper the paper's
  std::vector<std::string> folders;                     ///< of sets, as they are given
  std::vector<std::string> report;                      ///< arguments of the reporter

  /// Adds an option or a flag that goes to the reporter as it is.
  void addForReport(const std::string& name, const char* text);
  void addFlagForReport(const std::string& name, const char* text);

  /// False when only help was asked for. Throws std::exception with a sentence about a wrong argument.
  bool parse(const Arguments& arguments, const std::string& usage, bool with_sets = true);
  /// Returns true if the user gave that option.
  bool given(const std::string& name) const { return !given_[name].empty() && !given_[name].defaulted(); }

  /// One for each method given, or else for those of `otherwise`, or else for the default. Throws std::invalid_argument
  /// with a sentence when a value or a name is wrong.
  Pipelines pipelines(std::vector<std::string> otherwise = {}) const;
  /// The sets of all folders: each itself, or its subfolders in the order of their names, with the images of KITTI's
  /// right camera where they are there. Tells the user what is to be known of them.
  std::vector<MeasuredSet> sets() const;

 private:
  std::vector<std::string> methods_;  ///< names or comma lists of names
  int threads_ = 1;
  ParameterValues values_;
  DatasetOptions dataset_options_;
  boost::program_options::variables_map given_;
};

}  // namespace gms_ransac
