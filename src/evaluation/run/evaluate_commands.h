// The subcommands of `evaluate`, and the options that they share: every parameter of the core (cfg/parameters.py),
// `foo_bar` as --foo-bar. A command takes the arguments behind its name and returns the exit status; bad input is an
// exception with one clear sentence.
#pragma once

#include <string>
#include <vector>

#include <boost/program_options.hpp>

#include "gms_ransac/match_filter.h"
#include "methods/method.h"
#include "parameter.h"
#include "program.h"

namespace gms_ransac {

int evaluateRun(const Arguments& arguments);
int evaluateOdometry(const Arguments& arguments);
int evaluateSweep(const Arguments& arguments);
int evaluateTables(const Arguments& arguments);
int evaluateTrust(const Arguments& arguments);

/// Options of the user, from which those of pipelines are made.
struct PipelineArguments {
  std::vector<std::string> methods;  ///< names or comma lists of names
  int threads = 1;
  MatchFilterOptions base;  ///< the defaults; with --paper the paper's

  /// Adds the options to a description; the values land in this object, which must outlive the parsing. With --paper
  /// among the words `given` the defaults are the paper's.
  void addTo(boost::program_options::options_description& description, const Arguments& given);
  /// One for each method given, or else for those of `otherwise`, or else for the default. Throws std::invalid_argument
  /// with a sentence when a value or a name is wrong.
  std::vector<MatchFilterOptions> pipelines(std::vector<std::string> otherwise = {}) const;

 private:
  ParameterValues values_;
};

std::vector<std::string> allMethodNames();

}  // namespace gms_ransac
