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

  bool accepts(const ParameterValue& value) const;
  bool inRange(double number) const;
  /// The accepted values: "a whole number between 1 and 16", "one of 'a' 'b'".
  std::string accepted() const;
  /// The value as the type of this parameter; none if it has another type. A whole number is a number. The range
  /// is not checked.
  std::optional<ParameterValue> convert(const ParameterValue& value) const;
  /// From text: 1, on, yes are true and 0, off, no false, too.
  std::optional<ParameterValue> parse(const std::string& text) const;
};

std::string toText(const ParameterValue& value);

/// "<name> is '<value>'; it must be <accepted>"
std::string refusal(const std::string& name, const std::string& value, const std::string& accepted);

/// Those that set a field of MatchFilterOptions, in the table's order.
const std::vector<Parameter>& coreParameters();

/// Throws std::invalid_argument naming what is unknown, of another type or out of range.
void setParameters(const ParameterValues& values, MatchFilterOptions& options);
ParameterValues parametersOf(const MatchFilterOptions& options);

}  // namespace gms_ransac
