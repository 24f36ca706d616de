#include "run/pipeline_options.h"

#include <cstdio>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include "command_line.h"
#include "program.h"

namespace gms_ransac {

namespace po = boost::program_options;

namespace {

std::string helpText(const Parameter& parameter) {
  std::string choices;
  for (const std::string& choice : parameter.choices) {
    if (!choice.empty()) choices += (choices.empty() ? ": " : ", ") + choice;
  }
  return parameter.sentence + choices;
}

bool hasOldOption(const Parameter& parameter, const std::string& name) {
  const auto is_name = [&](const std::string& old_name) { return optionName(old_name) == name; };
  return std::any_of(parameter.old_names.begin(), parameter.old_names.end(), is_name) ||
         std::any_of(parameter.old_options.begin(), parameter.old_options.end(), is_name);
}

void warnOfOldName(const std::string& old_name, const std::string& names) {
  std::cerr << "--" << old_name << " is now called " << names << "; the old name still works\n";
}

ParameterValues parseOldGrid(const std::string& text) {
  warnOfOldName("grid", "--gms-grid-columns and --gms-grid-rows");
  int columns = 0, rows = 0;
  char end = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &columns, &rows, &end) != 2) {
    throw std::invalid_argument("--grid is '" + text + "'; it must look like 20x20");
  }
  return {{"gms_grid_columns", columns}, {"gms_grid_rows", rows}};
}

}  // namespace

void PipelineArguments::addTo(po::options_description& description, const std::vector<std::string>& given) {
  if (std::find(given.begin(), given.end(), "--paper") != given.end()) base = MatchFilterOptions::paper();
  auto add = description.add_options();
  add("paper", "the paper's method and settings, literally, where no option says otherwise");
  add("method,m", po::value(&methods)->composing(), "method, or several with commas between (see evaluate --list)");
  const ParameterValues defaults = parametersOf(base);
  for (const Parameter& parameter : coreParameters()) {
    if (parameter.name == "method") continue;
    const auto take = [this, &parameter](const std::string& text) {
      const std::optional<ParameterValue> value = parameter.parse(text);
      if (!value || !parameter.accepts(*value)) {
        throw std::invalid_argument(refusal("--" + optionName(parameter.name), text, parameter.accepted()));
      }
      const auto* word = std::get_if<std::string>(&*value);
      if (word) currentName("--" + optionName(parameter.name), text, *word);
      values_[parameter.name] = *value;
    };
    add(optionName(parameter.name).c_str(),
        po::value<std::string>()->default_value(toText(defaults.at(parameter.name)))->notifier(take),
        helpText(parameter).c_str());
  }
  add("grid", po::value(&old_grid_), "old name: --gms-grid-columns and --gms-grid-rows, as in 20x20");
  add("threads", po::value(&threads)->default_value(threads), "of extraction and matching");
}

MatchFilterOptions PipelineArguments::options(const std::string& method) const {
  MatchFilterOptions result = base;
  setParameters(values_, result);
  if (!old_grid_.empty()) setParameters(parseOldGrid(old_grid_), result);
  result.method = method;
  result.extractor.threads = threads;
  result.matcher_threads = threads;
  result.validate();
  return result;
}

std::vector<std::string> PipelineArguments::methodNames() const {
  if (methods.empty()) return {base.method};
  return parseMethodNames(methods);
}

std::string optionName(const std::string& parameter) {
  std::string name = parameter;
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

std::pair<std::string, std::string> parseOldOption(const std::string& word) {
  if (word.compare(0, 2, "--") != 0) return {};
  const size_t equals = word.find('=');
  const std::string name = word.substr(2, equals - 2);
  for (const Parameter& parameter : coreParameters()) {
    if (!hasOldOption(parameter, name)) continue;
    warnOfOldName(name, "--" + optionName(parameter.name));
    // Switches had no value.
    const bool on = std::holds_alternative<bool>(parameter.default_value);
    return {optionName(parameter.name), equals != std::string::npos ? word.substr(equals + 1) : on ? "1" : ""};
  }
  return {};
}

std::vector<std::string> parseMethodNames(const std::vector<std::string>& given) {
  std::vector<std::string> names;
  for (const std::string& list : given) {
    if (list.empty()) findMethod(list);  // complains with the list of known names
    for (const std::string& name : splitAtCommas(list))
      names.push_back(currentName("--method", name, findMethod(name).name));
  }
  return names;
}

std::string methodTable() {
  std::ostringstream text;
  for (const MethodEntry& method : methods()) {
    text << method.name << "\n    " << method.source << ": " << method.summary << "\n";
  }
  return text.str();
}

}  // namespace gms_ransac
