// The command lines of the offline programs: options, words without a name, help, and the checks that several need.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <boost/program_options.hpp>

#include "datasets/dataset.h"

namespace gms_ransac {

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

/// Adds the options of a data set.
void addDatasetOptions(boost::program_options::options_description& description, DatasetOptions& dataset);

/// Throws std::invalid_argument about the first option with a value below 1.
void requireAtLeastOne(std::initializer_list<std::pair<const char*, int>> options);

/// "a,b,c" -> a, b, c.
std::vector<std::string> splitAtCommas(const std::string& text);

/// The whole numbers from 1 on in a list with commas; std::invalid_argument about the option where there is another.
std::vector<int> parsePositives(const std::string& list, const std::string& option);

}  // namespace gms_ransac
