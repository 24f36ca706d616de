// How fields of structs of options become parameters and back. scripts/generate_parameters.py writes, for each struct,
//   template <class Visitor> void visitFields(Struct& options, Visitor&& visit)   // visit("name", options.field)
// and Words for the enumerations. A std::optional field is not set while the parameter has its default.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <type_traits>

#include "parameter.h"

namespace gms_ransac {

/// The words of an enumeration: pairs of word and enumerator, `kAll`.
template <class Enum>
struct Words;

/// Throws std::invalid_argument for a name that is not in the table.
const Parameter& findParameter(const std::vector<Parameter>& table, const std::string& name);

namespace binding {

template <class Field>
ParameterValue toValue(const Field& field) {
  if constexpr (std::is_enum_v<Field>) {
    for (const auto& [word, enumerator] : Words<Field>::kAll) {
      if (enumerator == field) return std::string(word);
    }
    return std::string();
  } else if constexpr (std::is_same_v<Field, uint64_t>) {
    return static_cast<int>(field);
  } else {
    return field;
  }
}

template <class Field>
void fromValue(const ParameterValue& value, Field& field) {
  if constexpr (std::is_enum_v<Field>) {
    for (const auto& [word, enumerator] : Words<Field>::kAll) {
      if (std::get<std::string>(value) == word) field = enumerator;
    }
  } else if constexpr (std::is_same_v<Field, uint64_t>) {
    field = static_cast<uint64_t>(std::get<int>(value));
  } else {
    field = std::get<Field>(value);
  }
}

}  // namespace binding

/// Visitor: sets the fields that have a value, which must be one that the parameter accepts.
struct FieldWriter {
  const std::vector<Parameter>& table;
  const ParameterValues& values;

  template <class Field>
  void operator()(const char* name, Field& field) {
    const auto value = values.find(name);
    if (value != values.end()) binding::fromValue(value->second, field);
  }
  template <class Field>
  void operator()(const char* name, std::optional<Field>& field) {
    const auto value = values.find(name);
    if (value == values.end()) return;
    field.reset();
    if (value->second != findParameter(table, name).default_value) binding::fromValue(value->second, field.emplace());
  }
};

/// `values` as the types of the table; throws std::invalid_argument with a sentence for what is refused.
ParameterValues checked(const std::vector<Parameter>& table, const ParameterValues& values);

}  // namespace gms_ransac
