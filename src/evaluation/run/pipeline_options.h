// The command-line options that choose a pipeline, shared by the subcommands of `evaluate`.
#pragma once

#include <string>
#include <vector>

#include <boost/program_options.hpp>
#include <nlohmann/json.hpp>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

/// What the user asked for; `options(method)` is what the pipeline gets.
struct PipelineArguments {
  std::vector<std::string> methods;  ///< names or comma lists of names; empty: the default method
  std::string model = "essential";
  std::string grid;  ///< "COLUMNSxROWS"; "": the method's own
  std::string acceptance = "own", distance_reading = "displacement";
  std::string threshold;  ///< pixels; "": the model's own
  int threads = 1;
  MatchFilterOptions base;

  /// Adds the options to a description; the values land in this object, which must outlive the parsing. With --paper
  /// among the words `given` the defaults are the paper's.
  void addTo(boost::program_options::options_description& description, const std::vector<std::string>& given);
  /// Throws std::invalid_argument with a sentence when a value or a name is wrong.
  MatchFilterOptions options(const std::string& method) const;
  std::vector<std::string> methodNames() const;
};

/// What decides the figures of a run besides images and methods, for telling whether two runs belong together.
nlohmann::json pipelineJson(const MatchFilterOptions& options);

/// "a,b,c" -> a, b, c.
std::vector<std::string> splitAtCommas(const std::string& text);

/// Names given one by one, as comma lists or both, in order. Throws std::invalid_argument for one that is unknown.
std::vector<std::string> parseMethodNames(const std::vector<std::string>& given);

/// The table of methods as text, for `evaluate --list`.
std::string methodTable();

}  // namespace gms_ransac
