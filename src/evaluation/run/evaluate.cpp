// Program: match filters compared on one's own images, without a ROS master.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <stdexcept>

#include "methods/method.h"
#include "run/evaluate_commands.h"

namespace gms_ransac {

namespace fs = std::filesystem;
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

/// The sets that a folder is or holds.
std::vector<std::string> setsIn(const std::string& folder) {
  if (!fs::is_directory(folder) || layoutOf(folder)) return {folder};  // a bag, or a set
  std::vector<std::string> sets;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!layoutOf(entry.path().string())) continue;
    sets.push_back(entry.path().string());
    for (const char* right : {"image_1", "image_r"}) {
      if (kittiRigOf((entry.path() / right).string())) sets.push_back((entry.path() / right).string());
    }
  }
  std::sort(sets.begin(), sets.end());
  if (sets.empty()) return {folder};  // opening it reports what is missing
  return sets;
}

}  // namespace

void CommandLine::addForReport(const std::string& name, const char* text) {
  const auto store = [this, name](const std::string& value) { report.insert(report.end(), {"--" + name, value}); };
  options.add_options()(name.c_str(), po::value<std::string>()->notifier(store), text);
}

void CommandLine::addFlagForReport(const std::string& name, const char* text) {
  const auto store = [this, name](bool given) {
    if (given) report.push_back("--" + name);
  };
  options.add_options()(name.c_str(), po::bool_switch()->notifier(store), text);
}

bool CommandLine::parse(const Arguments& arguments, const std::string& usage, bool with_sets) {
  if (std::find(arguments.begin(), arguments.end(), "--paper") != arguments.end()) base = MatchFilterOptions::paper();
  auto add = options.add_options();
  if (with_sets) addDatasetOptions(options, dataset_options_);
  add("paper",
      "defaults as in the paper: cp_ransac on cv::ORB, without alignment, refinement, judgement and one_to_one (see "
      "README)");
  add("method,m", po::value(&methods_)->composing(),
      "method, several with commas between, or all (see evaluate --list)");
  const ParameterValues defaults = parametersOf(base);
  for (const Parameter& parameter : coreParameters()) {
    if (parameter.name == "method") continue;
    const auto store = [this, &parameter](const std::string& text) {
      const std::optional<ParameterValue> value = parameter.parse(text);
      if (!value) throw std::invalid_argument(refusal("--" + optionName(parameter.name), text, parameter.accepted()));
      values_[parameter.name] = *value;
    };
    add(optionName(parameter.name).c_str(),
        po::value<std::string>()->default_value(toText(defaults.at(parameter.name)))->notifier(store),
        helpText(parameter).c_str());
  }
  add("threads", withDefault(threads_), "of extraction and matching");
  std::vector<Positional> positional;
  if (with_sets) positional.push_back({"set", -1, po::value(&folders)});
  const auto parsed = parseCommandLine(arguments, usage, options, positional);
  if (parsed) given_ = *parsed;
  return parsed.has_value();
}

Pipelines CommandLine::pipelines(std::vector<std::string> otherwise) const {
  std::vector<std::string> names = methods_.empty() ? std::move(otherwise) : splitAtCommas(methods_);
  if (methods_.empty() && names.empty()) names = {base.method};
  if (names == std::vector<std::string>{"all"}) {
    names.clear();
    for (const MethodEntry& method : methods()) names.emplace_back(method.name);
  }
  if (names.empty()) names.emplace_back();  // is refused with the list of known names
  Pipelines made;
  for (const std::string& name : names) {
    MatchFilterOptions& made_options = made.emplace_back(base);
    setParameters(values_, made_options);
    made_options.method = findMethod(name).name;
    made_options.extractor.threads = made_options.matcher_threads = threads_;
    made_options.validate();
  }
  return made;
}

std::vector<MeasuredSet> CommandLine::sets() const {
  std::vector<MeasuredSet> sets;
  const bool rolling = pipelines().front().robust.rolling_shutter_readout > 0;
  for (const std::string& folder : folders) {
    for (const std::string& path : setsIn(folder)) {
      const Dataset& dataset = sets.emplace_back(MeasuredSet{Dataset::open(path, dataset_options_), {}}).dataset;
      sets.back().noise = defaultTruthNoise(path);
      std::cerr << dataset.path() << ": " << dataset.calibrationText() << '\n';
      for (const std::string& note : dataset.notes()) std::cerr << note << '\n';
      if (rolling && !dataset.stamp(0)) {
        std::cerr << path << ": a list of pairs has no stamps, so --rolling-shutter-readout is not applied\n";
      }
    }
  }
  return sets;
}

}  // namespace gms_ransac

int main(int argc, char** argv) { return gms_ransac::runProgram(argc, argv, gms_ransac::evaluate); }
