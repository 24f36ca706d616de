// Rows of cfg/parameters.py and fields of any type: the one way from a value to a field and back.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "parameters/parameter.h"

namespace gms_ransac {

template <class Enum>
using Words = std::vector<std::pair<const char*, Enum>>;

namespace binding {

/// Throws std::invalid_argument as setParameters does.
void requireAccepted(const ParameterValues& values, const ParameterTable& table, const std::string& prefix);

/// `words`: from any enumerator to the words of its enumeration.
template <class Field, class WordsOf>
std::optional<ParameterValue> toValue(const Field& field, WordsOf words) {
  if constexpr (std::is_enum_v<Field>) {
    for (const auto& [word, enumerator] : words(field)) {
      if (enumerator == field) return std::string(word);
    }
    return std::string();
  } else if constexpr (std::is_same_v<Field, uint64_t>) {
    return static_cast<int>(std::min<uint64_t>(field, std::numeric_limits<int>::max()));
  } else {
    return field;
  }
}

template <class Field, class WordsOf>
std::optional<ParameterValue> toValue(const std::optional<Field>& field, WordsOf words) {
  return field ? toValue(*field, words) : std::nullopt;
}

template <class Field, class WordsOf>
void fromValue(const ParameterValue& value, const ParameterValue& /*not_set*/, Field& field, WordsOf words) {
  if constexpr (std::is_enum_v<Field>) {
    for (const auto& [word, enumerator] : words(field)) {
      if (std::get<std::string>(value) == word) field = enumerator;
    }
  } else if constexpr (std::is_same_v<Field, uint64_t>) {
    field = static_cast<uint64_t>(std::get<int>(value));
  } else {
    field = std::get<Field>(value);
  }
}

template <class Field, class WordsOf>
void fromValue(const ParameterValue& value, const ParameterValue& not_set, std::optional<Field>& field, WordsOf words) {
  field.reset();
  if (value != not_set) fromValue(value, not_set, field.emplace(), words);
}

}  // namespace binding

/// The words of a field that is no enumeration.
constexpr auto kNoWords = [](auto any) { return Words<decltype(any)>(); };

/// The rows of cfg/parameters.py that set fields of `Options`. scripts/generate_parameters.py writes
///   static const ParameterTable& table();
///   static void each(options, visit);  // calls visit(row, field, words) for every row that has a field
template <class Options>
struct ParameterFields;

template <class Options>
void setParameters(const ParameterValues& values, Options& options, const std::string& prefix) {
  binding::requireAccepted(values, ParameterFields<Options>::table(), prefix);
  ParameterFields<Options>::each(options, [&](const Parameter& row, auto& field, auto words) {
    const auto value = values.find(row.name);
    if (value != values.end()) binding::fromValue(*row.convert(value->second), row.default_value, field, words);
  });
}

template <class Options>
ParameterValues parametersOf(const Options& options) {
  ParameterValues values;
  ParameterFields<Options>::each(options, [&](const Parameter& row, const auto& field, auto words) {
    values[row.name] = binding::toValue(field, words).value_or(row.default_value);
  });
  return values;
}

}  // namespace gms_ransac
