#include "run/pipeline_options.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "command_line.h"
#include "methods/method.h"

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

}  // namespace

void PipelineArguments::addTo(po::options_description& description, const std::vector<std::string>& given) {
  if (std::find(given.begin(), given.end(), "--paper") != given.end()) base = MatchFilterOptions::paper();
  auto add = description.add_options();
  add("paper",
      "defaults as in the paper: cp_ransac on cv::ORB, without refinement, judgement and one_to_one (see README)");
  add("method,m", po::value(&methods)->composing(), "method, or several with commas between (see evaluate --list)");
  const ParameterValues defaults = parametersOf(base);
  for (const Parameter& parameter : coreParameters()) {
    if (parameter.name == "method") continue;
    const auto take = [this, &parameter](const std::string& text) {
      const std::optional<ParameterValue> value = parameter.parse(text);
      if (!value || !parameter.accepts(*value)) {
        throw std::invalid_argument(refusal("--" + optionName(parameter.name), text, parameter.accepted()));
      }
      values_[parameter.name] = *value;
    };
    add(optionName(parameter.name).c_str(),
        po::value<std::string>()->default_value(toText(defaults.at(parameter.name)))->notifier(take),
        helpText(parameter).c_str());
  }
  add("threads", po::value(&threads)->default_value(threads), "of extraction and matching");
}

MatchFilterOptions PipelineArguments::options(const std::string& method) const {
  MatchFilterOptions result = base;
  setParameters(values_, result);
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

std::vector<std::string> parseMethodNames(const std::vector<std::string>& given) {
  std::vector<std::string> names;
  for (const std::string& list : given) {
    if (list.empty()) findMethod(list);  // complains with the list of known names
    for (const std::string& name : splitAtCommas(list)) names.emplace_back(findMethod(name).name);
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
