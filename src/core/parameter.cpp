#include "parameter.h"

#include <algorithm>
#include <sstream>

#include "gms_ransac/core_parameters.h"
#include "methods/method.h"
#include "validation.h"
#include "worker_pool.h"

namespace gms_ransac {

namespace {

constexpr int kDigits = 10;  // enough for every bound of a range to be read back as it is

std::string numberText(double number) {
  std::ostringstream text;
  text.precision(kDigits);
  text << number;
  return text.str();
}

template <class Number>
std::optional<ParameterValue> parseNumber(const std::string& text) {
  std::istringstream stream(text);
  Number number;
  if (!(stream >> number) || !stream.eof()) return std::nullopt;
  return number;
}

bool isNumber(const ParameterValue& value) {
  return std::holds_alternative<int>(value) || std::holds_alternative<double>(value);
}

double numberOf(const ParameterValue& value) {
  return std::holds_alternative<int>(value) ? std::get<int>(value) : std::get<double>(value);
}

}  // namespace

std::string toText(const ParameterValue& value) {
  if (isNumber(value)) return numberText(numberOf(value));
  if (const auto* word = std::get_if<std::string>(&value)) return *word;
  return std::get<bool>(value) ? "true" : "false";
}

std::string refusal(const std::string& name, const std::string& value, const std::string& accepted) {
  return name + " is '" + value + "'; it must be " + accepted;
}

bool Parameter::accepts(const ParameterValue& value) const {
  const std::optional<ParameterValue> converted = convert(value);
  if (!converted) return false;
  if (const auto* word = std::get_if<std::string>(&*converted)) {
    return choices.empty() || std::find(choices.begin(), choices.end(), *word) != choices.end();
  }
  if (!isNumber(*converted)) return true;
  return inRange(numberOf(*converted)) || *converted == default_value;
}

bool Parameter::inRange(double number) const { return number >= low && number <= high; }

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
  if (!inRange(numberOf(default_value))) text += ", or " + numberText(numberOf(default_value));
  return text;
}

std::optional<ParameterValue> Parameter::convert(const ParameterValue& value) const {
  if (std::holds_alternative<double>(default_value) && isNumber(value)) return numberOf(value);
  if (value.index() != default_value.index()) return std::nullopt;
  return value;
}

std::optional<ParameterValue> Parameter::parse(const std::string& text) const {
  if (std::holds_alternative<bool>(default_value)) {
    for (const char* yes : {"true", "1", "on", "yes"}) {
      if (text == yes) return true;
    }
    for (const char* no : {"false", "0", "off", "no"}) {
      if (text == no) return false;
    }
    return std::nullopt;
  }
  if (std::holds_alternative<int>(default_value)) return parseNumber<int>(text);
  if (std::holds_alternative<double>(default_value)) return parseNumber<double>(text);
  return convert(text);
}

const Parameter& findParameter(const std::vector<Parameter>& table, const std::string& name) {
  for (const Parameter& parameter : table) {
    if (parameter.name == name) return parameter;
  }
  throw std::invalid_argument("there is no parameter '" + name + "'");
}

ParameterValues checked(const std::vector<Parameter>& table, const ParameterValues& values) {
  ParameterValues converted;
  for (const auto& [name, value] : values) {
    const Parameter& parameter = findParameter(table, name);
    if (!parameter.accepts(value)) {
      throw std::invalid_argument(refusal(name, toText(value), parameter.accepted()));
    }
    converted[name] = *parameter.convert(value);
  }
  return converted;
}

namespace {

template <class Visitor>
void visitAll(MatchFilterOptions& options, Visitor&& visit) {
  visitFields(options, visit);
  visitFields(options.extractor, visit);
  visitFields(options.motion_statistics, visit);
  visitFields(options.robust, visit);
}

/// Visitor: collects the values of all fields.
struct FieldReader {
  ParameterValues& values;

  template <class Field>
  void operator()(const char* name, const Field& field) {
    values[name] = binding::toValue(field);
  }
  template <class Field>
  void operator()(const char* name, const std::optional<Field>& field) {
    values[name] = field ? binding::toValue(*field) : findParameter(coreTable(), name).default_value;
  }
};

/// Visitor: refuses a field out of its range, or a word that no choice knows.
struct RangeCheck {
  template <class Field>
  void operator()(const char* name, const Field& field) const {
    const Parameter& parameter = findParameter(coreTable(), name);
    const ParameterValue value = binding::toValue(field);
    if (!(isNumber(value) ? parameter.inRange(numberOf(value)) : parameter.accepts(value))) {
      throw std::invalid_argument(refusal(name, toText(value), parameter.accepted()));
    }
  }
  void operator()(const char* /*seed*/, const uint64_t& /*any*/) const {}
  template <class Field>
  void operator()(const char* name, const std::optional<Field>& field) const {
    if (field) (*this)(name, *field);
  }
};

/// Refuses an option that has a row in cfg/parameters.py and is out of its range.
template <class Options>
void requireInRanges(Options options) {
  visitFields(options, RangeCheck());
}

}  // namespace

void FeatureExtractorOptions::validate() const {
  requireInRanges(*this);
  requireInRange("threads", threads, 1, kMostThreads);
}

void MotionStatisticsOptions::validate() const { requireInRanges(*this); }

void RobustOptions::validate() const { requireInRanges(*this); }

void MatchFilterOptions::validate() const {
  findMethod(method);
  extractor.validate();
  motion_statistics.validate();
  HammingMatcherOptions matcher;
  matcher.threads = matcher_threads;
  matcher.validate();
  requireInRanges(*this);
  robust.validate();
}

ModelType parseModelType(const std::string& name) {
  RobustOptions options;
  visitFields(options, FieldWriter{coreTable(), checked(coreTable(), {{"model", name}})});
  return options.model;
}

std::string toString(ModelType model) { return toText(binding::toValue(model)); }

const std::vector<Parameter>& coreParameters() { return coreTable(); }

void setParameters(const ParameterValues& values, MatchFilterOptions& options) {
  visitAll(options, FieldWriter{coreTable(), checked(coreTable(), values)});
}

ParameterValues parametersOf(const MatchFilterOptions& options) {
  ParameterValues values;
  MatchFilterOptions copy = options;
  visitAll(copy, FieldReader{values});
  return values;
}

}  // namespace gms_ransac
