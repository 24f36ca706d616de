// Values of parameters, as text, by type and through dynamic_reconfigure: taken, or refused with a sentence that names
// the parameter.
#include <stdexcept>

#include <dynamic_reconfigure/config_tools.h>
#include <gms_ransac/MatchFilterConfig.h>

#include "fuzz_messages.h"
#include "gms_ransac/match_filter.h"
#include "methods/method.h"
#include "node/reconfigure.h"

namespace gms_ransac {
namespace {

void demandSentence(const std::invalid_argument& error) {
  demand(std::string(error.what()).find(" is ") != std::string::npos,
         std::string("a refusal is a sentence: ") + error.what());
}

ParameterValue fuzzedValue(FuzzInput& input, const Parameter& parameter) {
  const int kind = input.between(0, 6);
  if (kind == 0) return input.flag();
  if (kind == 1) return input.raw<int32_t>();
  if (kind == 2) return input.number(parameter.low, parameter.high);
  if (kind == 3) return input.text(40);
  if (kind == 4) return parameter.default_value;
  if (kind == 5) return parameter.choices.empty() ? std::string() : input.oneOf(parameter.choices);
  return static_cast<int>(std::clamp(input.number(parameter.low, parameter.high), -1e9, 1e9) == 0);
}

void checkText(FuzzInput& input, const Parameter& parameter) {
  const std::string text = input.text(40);
  const std::optional<ParameterValue> value = parameter.parse(text);
  if (!value) return;
  demand(value->index() == parameter.default_value.index(), "what is parsed has the parameter's type");
  MatchFilterOptions options;
  setParameters({{parameter.name, *value}}, options);
}

void checkValues(FuzzInput& input) {
  ParameterValues values;
  for (int n = input.between(0, 8); n > 0; --n) {
    const Parameter& parameter = input.oneOf(coreParameters());
    values[input.byte() > 250 ? input.text(20) : parameter.name] = fuzzedValue(input, parameter);
  }
  MatchFilterOptions options;
  try {
    setParameters(values, options);
    options.validate();
  } catch (const std::invalid_argument& error) {
    return demandSentence(error);
  }
  // Accepted options work.
  makeMethod(options);
  const ParameterValues in_force = parametersOf(options);
  for (const auto& [name, value] : in_force) {
    const auto* number = std::get_if<double>(&value);
    demand(number == nullptr || std::isfinite(*number), name + " is finite");
  }
}

void checkReconfigure(FuzzInput& input) {
  using dynamic_reconfigure::ConfigTools;
  MatchFilterConfig config = MatchFilterConfig::__getDefault__();
  dynamic_reconfigure::Config message;
  for (int n = input.between(0, 8); n > 0; --n) {
    const Parameter& parameter = input.oneOf(coreParameters());
    std::visit([&](const auto& typed) { ConfigTools::appendParameter(message, parameter.name, typed); },
               fuzzedValue(input, parameter));
  }
  config.__fromMessage__(message);
  message = dynamic_reconfigure::Config();
  config.__toMessage__(message);
  RuntimeOptions options;
  try {
    setParameters(valuesOf(message), options, "parameter ~");
  } catch (const std::invalid_argument& error) {
    return demandSentence(error);
  }
  options.processor.core.validate();
}

}  // namespace

void check(FuzzInput input) {
  quietRos();  // dynamic_reconfigure logs every name that it does not know
  const int kind = input.between(0, 2);
  if (kind == 0) return checkText(input, input.oneOf(coreParameters()));
  if (kind == 1) return checkValues(input);
  checkReconfigure(input);
}

}  // namespace gms_ransac
