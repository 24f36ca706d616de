// The room parameters finds, reads and sets options by name. A new one is a row of cfg/parameters.py; nothing is added
// here.
//
// The options by name: what the node's parameters and the options of `evaluate` are made of. The table is
// cfg/parameters.py.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace gms_ransac {

struct MatchFilterOptions;

using ParameterValue = std::variant<bool, int, double, std::string>;
using ParameterValues = std::map<std::string, ParameterValue>;

struct Parameter {
  std::string name;
  ParameterValue default_value;  ///< defines the type; if out of range it means "not set"
  double low, high;              ///< of a number
  std::string unit;              ///< of a number; of a word without choices what it must be
  std::string sentence;
  std::vector<std::string> choices;  ///< of a word; empty: any

  /// The value in the type of this parameter; none if it has another type, is out of range or unknown. A whole number
  /// is a number, and 1500.0 is whole.
  std::optional<ParameterValue> convert(const ParameterValue& value) const;
  /// The same from text: 1, on, yes are true and 0, off, no false, too; 4e-05 and 1e3 are numbers.
  std::optional<ParameterValue> parse(const std::string& text) const;
  /// The accepted values: "a whole number between 1 and 16", "one of 'a' 'b'".
  std::string accepted() const;
  /// A value of this type is within the range or among the choices. The default may be outside the range.
  bool allows(const ParameterValue& value) const;
};

using ParameterTable = std::vector<Parameter>;

std::string toText(const ParameterValue& value);

/// "<name> is '<value>'; it must be <accepted>"
std::string refusal(const std::string& name, const std::string& value, const std::string& accepted);

const ParameterTable& coreParameters();

/// Null if the table has none of that name.
const Parameter* findParameter(const ParameterTable& table, const std::string& name);

/// Sets the fields of these parameters. Throws std::invalid_argument and changes nothing if one is unknown, of another
/// type or out of range; its sentences name all of these, behind `prefix`. `Options`: MatchFilterOptions, or those of
/// the node (node/read_parameters.h).
template <class Options>
void setParameters(const ParameterValues& values, Options& options, const std::string& prefix = std::string());
/// The values of all fields; of one that is not set the default.
template <class Options>
ParameterValues parametersOf(const Options& options);

}  // namespace gms_ransac
