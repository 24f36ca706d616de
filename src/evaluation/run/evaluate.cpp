// Program: match filters compared on one's own images, without a ROS master.
#include <algorithm>
#include <iostream>
#include <stdexcept>

#include "run/evaluate_commands.h"

namespace gms_ransac {

namespace po = boost::program_options;

namespace {

struct Command {
  const char* name;
  const char* summary;
  int (*run)(const Arguments&);
};

int evaluateMerge(const Arguments& arguments) {
  Arguments report = {"merge"};
  report.insert(report.end(), arguments.begin(), arguments.end());
  return Reporter(report).finish();
}

constexpr Command kCommands[] = {
    {"run", "work through a data set: a record for each pair and method, and a table", evaluateRun},
    {"sweep", "success and effort of each method against the outlier ratio, on drawn scenes", evaluateSweep},
    {"tables", "the paper's tables and figures on one's own images", evaluateTables},
    {"trust", "how often OK is wrong, and whether covariances are true, on sets and on scenes that try to fool",
     evaluateTrust},
    {"odometry", "drift of stereo, RGB-D and single cameras over whole sequences", evaluateOdometry},
    {"merge", "join the parts that evaluate tables --shard made", evaluateMerge},
};

int evaluate(const Arguments& arguments) {
  const std::string first = arguments.empty() ? "" : arguments.front();
  if (first == "--list") {
    std::cout << methodsText();
    return 0;
  }
  if (first == "--help" || first == "-h") {
    std::cout << "usage: evaluate COMMAND [options]    (evaluate COMMAND --help tells more)\n";
    for (const Command& command : kCommands) {
      const std::string name = command.name;
      std::cout << "  " << name << std::string(10 - name.size(), ' ') << command.summary << "\n";
    }
    std::cout << "  --list    the methods that can be compared\n";
    return 0;
  }
  for (const Command& command : kCommands) {
    if (first == command.name) return command.run(Arguments(arguments.begin() + 1, arguments.end()));
  }
  throw std::invalid_argument((first.empty() ? "no command given" : "unknown command '" + first + "'") +
                              "; see evaluate --help");
}

/// "first_group_fraction" -> "first-group-fraction".
std::string optionName(std::string parameter) {
  std::replace(parameter.begin(), parameter.end(), '_', '-');
  return parameter;
}

std::string helpText(const Parameter& parameter) {
  std::string choices;
  for (const std::string& choice : parameter.choices) {
    if (!choice.empty()) choices += (choices.empty() ? ": " : ", ") + choice;
  }
  return parameter.sentence + choices;
}

}  // namespace

void PipelineArguments::addTo(po::options_description& description, const Arguments& given) {
  if (std::find(given.begin(), given.end(), "--paper") != given.end()) base = MatchFilterOptions::paper();
  auto add = description.add_options();
  add("paper",
      "defaults as in the paper: cp_ransac on cv::ORB, without refinement, judgement and one_to_one (see README)");
  add("method,m", po::value(&methods)->composing(),
      "method, several with commas between, or all (see evaluate --list)");
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
  add("threads", withDefault(threads), "of extraction and matching");
}

std::vector<MatchFilterOptions> PipelineArguments::pipelines(std::vector<std::string> otherwise) const {
  std::vector<std::string> names = methods.empty() ? std::move(otherwise) : splitAtCommas(methods);
  if (methods.empty() && names.empty()) names = {base.method};
  if (names == std::vector<std::string>{"all"}) names = allMethodNames();
  if (names.empty()) names.emplace_back();  // is refused with the list of known names
  std::vector<MatchFilterOptions> made;
  for (const std::string& name : names) {
    MatchFilterOptions& options = made.emplace_back(base);
    setParameters(values_, options);
    options.method = findMethod(name).name;
    options.extractor.threads = options.matcher_threads = threads;
    options.validate();
  }
  return made;
}

std::vector<std::string> allMethodNames() {
  std::vector<std::string> names;
  for (const MethodEntry& method : methods()) names.push_back(method.name);
  return names;
}

}  // namespace gms_ransac

int main(int argc, char** argv) { return gms_ransac::runProgram(argc, argv, gms_ransac::evaluate); }
