// The options of a pipeline as JSON. Only for the few files that are compiled with JSON.
#pragma once

#include <variant>

#include <nlohmann/json.hpp>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/parameter.h"

namespace gms_ransac {

/// Every parameter of the core by its name.
inline nlohmann::json optionsJson(const MatchFilterOptions& options) {
  nlohmann::json values;
  for (const auto& [name, value] : parametersOf(options)) {
    std::visit([&json_value = values[name]](const auto& typed) { json_value = typed; }, value);
  }
  return values;
}

}  // namespace gms_ransac
