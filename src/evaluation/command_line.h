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

/// What words without an option's name stand for.
struct Positional {
  const char* name;
  int count;  ///< of words; -1: any number
  const boost::program_options::value_semantic* value;
};

/// Reads the words into what the options refer to. Nothing when help was asked for, which is then printed: `usage` and
/// the options. `old_names`: as program_options' extra_parser. Throws std::exception with a sentence about a wrong
/// word.
std::optional<boost::program_options::variables_map> parseCommandLine(
    const Arguments& arguments, const std::string& usage, const boost::program_options::options_description& options,
    const std::vector<Positional>& positional = {}, const boost::program_options::ext_parser& old_names = {});

/// Adds the options that every program has which reads a data set.
void addDatasetOptions(boost::program_options::options_description& description, DatasetOptions& dataset);

/// Throws std::invalid_argument about the first option whose value is not.
void requireAtLeastOne(std::initializer_list<std::pair<const char*, int>> options);

/// "a,b,c" -> a, b, c.
std::vector<std::string> splitAtCommas(const std::string& text);

/// The whole numbers from 1 on in a list with commas; std::invalid_argument about the option where there is another.
std::vector<int> parsePositives(const std::string& list, const std::string& option);

}  // namespace gms_ransac
