// The command-line options that choose a pipeline, shared by the subcommands of `evaluate`: every parameter of the core
// (cfg/parameters.py), `foo_bar` as --foo-bar.
#pragma once

#include <string>
#include <vector>

#include <boost/program_options.hpp>

#include "gms_ransac/match_filter.h"
#include "parameter.h"

namespace gms_ransac {

/// Options of the user; `options(method)` makes those of a pipeline.
struct PipelineArguments {
  std::vector<std::string> methods;  ///< names or comma lists of names; empty: the default method
  int threads = 1;
  MatchFilterOptions base;  ///< the defaults; with --paper the paper's

  /// Adds the options to a description; the values land in this object, which must outlive the parsing. With --paper
  /// among the words `given` the defaults are the paper's.
  void addTo(boost::program_options::options_description& description, const std::vector<std::string>& given);
  /// Throws std::invalid_argument with a sentence when a value or a name is wrong.
  MatchFilterOptions options(const std::string& method) const;
  std::vector<std::string> methodNames() const;

 private:
  ParameterValues values_;
};

/// "first_group_fraction" -> "first-group-fraction".
std::string optionName(const std::string& parameter);

/// Names given one by one, as comma lists or both, in order. Throws std::invalid_argument for one that is unknown.
std::vector<std::string> parseMethodNames(const std::vector<std::string>& given);

/// The table of methods as text, for `evaluate --list`.
std::string methodTable();

}  // namespace gms_ransac
