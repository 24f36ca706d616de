#include "parameters/parameter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>

#include "gms_ransac/core_parameters.h"
#include "methods/method.h"
#include "support/validation.h"
#include "support/worker_pool.h"

namespace gms_ransac {

namespace {

constexpr int kDigits = 10;  // enough for every bound of a range to be read back as it is

std::string numberText(double number) {
  std::ostringstream text;
  text.precision(kDigits);
  text << number;
  return text.str();
}

std::optional<double> numberOf(const ParameterValue& value) {
  if (const auto* whole = std::get_if<int>(&value)) return *whole;
  if (const auto* number = std::get_if<double>(&value)) return *number;
  return std::nullopt;
}

/// The same number as an int; none if it has a fraction or is too large.
std::optional<int> wholeOf(double number) {
  const bool fits = std::abs(number) <= std::numeric_limits<int>::max();
  return fits && number == std::floor(number) ? std::optional(static_cast<int>(number)) : std::nullopt;
}

/// Refuses an option that has a row in cfg/parameters.py and is out of its range.
void requireInRanges(const MatchFilterOptions& options) {
  ParameterFields<MatchFilterOptions>::each(options, [](const Parameter& row, const auto& field, auto words) {
    const std::optional<ParameterValue> value = binding::toValue(field, words);
    if (value && !row.allows(*value)) throw std::invalid_argument(refusal(row.name, toText(*value), row.accepted()));
  });
}

template <class Part>
void requireInRanges(const Part& part, Part MatchFilterOptions::*field) {
  MatchFilterOptions all;
  all.*field = part;
  requireInRanges(all);
}

}  // namespace

std::string toText(const ParameterValue& value) {
  if (const std::optional<double> number = numberOf(value)) return numberText(*number);
  if (const auto* word = std::get_if<std::string>(&value)) return *word;
  return std::get<bool>(value) ? "true" : "false";
}

std::string refusal(const std::string& name, const std::string& value, const std::string& accepted) {
  return name + " is '" + value + "'; it must be " + accepted;
}

bool Parameter::allows(const ParameterValue& value) const {
  if (const std::optional<double> number = numberOf(value)) return *number >= low && *number <= high;
  const auto* word = std::get_if<std::string>(&value);
  return word == nullptr || choices.empty() || std::find(choices.begin(), choices.end(), *word) != choices.end();
}

std::optional<ParameterValue> Parameter::convert(const ParameterValue& value) const {
  ParameterValue typed = value;
  if (const auto* whole = std::get_if<int>(&value); whole && std::holds_alternative<double>(default_value)) {
    typed = static_cast<double>(*whole);
  }
  if (const auto* number = std::get_if<double>(&value); number && std::holds_alternative<int>(default_value)) {
    if (const std::optional<int> whole = wholeOf(*number)) typed = *whole;
  }
  if (typed.index() != default_value.index() || !(allows(typed) || typed == default_value)) return std::nullopt;
  return typed;
}

std::optional<ParameterValue> Parameter::parse(const std::string& text) const {
  static const std::map<std::string, bool> kFlags = {{"true", true},   {"1", true},  {"on", true},   {"yes", true},
                                                     {"false", false}, {"0", false}, {"off", false}, {"no", false}};
  if (std::holds_alternative<std::string>(default_value)) return convert(text);
  if (std::holds_alternative<bool>(default_value)) {
    const auto flag = kFlags.find(text);
    return flag == kFlags.end() ? std::nullopt : convert(flag->second);
  }
  double number = 0;
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  stream >> number;
  return stream && stream.eof() ? convert(number) : std::nullopt;
}

std::string Parameter::accepted() const {
  if (std::holds_alternative<bool>(default_value)) return "true or false";
  if (std::holds_alternative<std::string>(default_value)) {
    if (choices.empty()) return unit;
    std::string text = "one of";
    for (const std::string& choice : choices) text += " '" + choice + "'";
    return text;
  }
  std::string text = std::holds_alternative<int>(default_value) ? "a whole number" : "a number";
  text += " between " + numberText(low) + " and " + numberText(high);
  if (!unit.empty()) text += " " + unit;
  if (!allows(default_value)) text += ", or " + toText(default_value);
  return text;
}

void FeatureExtractorOptions::validate() const {
  requireInRanges(*this, &MatchFilterOptions::extractor);
  requireInRange("threads", threads, 1, kMostThreads);
}

void MotionStatisticsOptions::validate() const { requireInRanges(*this, &MatchFilterOptions::motion_statistics); }

void RobustOptions::validate() const { requireInRanges(*this, &MatchFilterOptions::robust); }

void MatchFilterOptions::validate() const {
  findMethod(method);
  requireInRanges(*this);
  extractor.validate();
  HammingMatcherOptions matcher;
  matcher.threads = matcher_threads;
  matcher.validate();
}

ModelType parseModelType(const std::string& name) {
  MatchFilterOptions options;
  setParameters({{"model", name}}, options);
  return options.robust.model;
}

std::string toString(ModelType model) {
  MatchFilterOptions options;
  options.robust.model = model;
  return toText(parametersOf(options).at("model"));
}

const ParameterTable& coreParameters() { return ParameterFields<MatchFilterOptions>::table(); }

const Parameter* findParameter(const ParameterTable& table, const std::string& name) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const Parameter& row) { return row.name == name; });
  return found == table.end() ? nullptr : &*found;
}

void binding::requireAccepted(const ParameterValues& values, const ParameterTable& table, const std::string& prefix) {
  std::string problem;
  for (const auto& [name, value] : values) {
    const Parameter* row = findParameter(table, name);
    if (row != nullptr && row->convert(value)) continue;
    if (!problem.empty()) problem += "; ";
    problem += row == nullptr ? "there is no parameter '" + name + "'"
                              : refusal(prefix + name, toText(value), row->accepted());
  }
  if (!problem.empty()) throw std::invalid_argument(problem);
}

template void setParameters(const ParameterValues&, MatchFilterOptions&, const std::string&);
template ParameterValues parametersOf(const MatchFilterOptions&);

}  // namespace gms_ransac
