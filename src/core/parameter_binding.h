// Binds a row of cfg/parameters.py to its field of any type. scripts/generate_parameters.py writes the tables.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "parameter.h"

namespace gms_ransac {

template <class Enum>
using Words = std::vector<std::pair<const char*, Enum>>;

namespace binding {

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

/// `access`: from options to the field. A std::optional field is not set while the parameter has its default.
template <class Options, class Access, class WordsOf>
BoundParameter<Options> bind(const Parameter& row, Access access, WordsOf words) {
  return {row, [=](const Options& options) { return binding::toValue(access(options), words); },
          [=, not_set = row.default_value](Options& options, const ParameterValue& value) {
            binding::fromValue(value, not_set, access(options), words);
          }};
}

}  // namespace gms_ransac
