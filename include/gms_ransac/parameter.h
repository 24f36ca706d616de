// The options by name: what the node's parameters and the options of `evaluate` are made of. The table is
// cfg/parameters.py.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace gms_ransac {

struct MatchFilterOptions;

using ParameterValue = std::variant<bool, int, double, std::string>;
using ParameterValues = std::map<std::string, ParameterValue>;

/// One row of the table.
struct Parameter {
  std::string name;
  ParameterValue default_value;  ///< says which type it is; beyond the range it stands for "not set"
  double low, high;              ///< of a number
  std::string unit;              ///< of a number; of a word without choices what it must be
  std::string sentence;
  std::vector<std::string> choices;                              ///< of a word; empty: any
  std::vector<std::string> old_names, old_options;               ///< still taken; the latter by `evaluate` alone
  std::vector<std::pair<std::string, std::string>> old_choices;  ///< {old, new}, still taken

  bool accepts(const ParameterValue& value) const;
  bool inRange(double number) const;
  /// What it accepts: "a whole number between 1 and 16", "one of 'a' 'b'".
  std::string accepted() const;
  /// The value as the type of this parameter; none where it cannot be taken for one. A whole number is a number, and an
  /// old word becomes the new one; the range is not looked at.
  std::optional<ParameterValue> convert(const ParameterValue& value) const;
  /// From text: 1, on, yes are true and 0, off, no false, too.
  std::optional<ParameterValue> parse(const std::string& text) const;
};

std::string toText(const ParameterValue& value);

/// "<name> is '<value>'; it must be <accepted>"
std::string refusal(const std::string& name, const std::string& value, const std::string& accepted);

/// Those that set a field of MatchFilterOptions, in the table's order.
const std::vector<Parameter>& coreParameters();

/// What a word of that parameter is called today: "lo_prosac" for method "fast", its name in earlier versions; else
/// `word`. Throws std::invalid_argument when the core has no such parameter.
std::string currentWord(const std::string& parameter, const std::string& word);

/// Throws std::invalid_argument with a sentence that names what is unknown, of another type or out of its range.
void setParameters(const ParameterValues& values, MatchFilterOptions& options);
ParameterValues parametersOf(const MatchFilterOptions& options);

}  // namespace gms_ransac
