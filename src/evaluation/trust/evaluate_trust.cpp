// `evaluate trust`: how often an answer that says OK is wrong, and whether its covariance and its match probabilities
// are true, on sets with truth and on scenes that try to fool it.
#include <fstream>
#include <iostream>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include <boost/program_options.hpp>

#include "program.h"
#include "run/evaluate_commands.h"
#include "run/pipeline_options.h"
#include "run/work_folder.h"
#include "scenes/drawn_scenes.h"
#include "trust/trust_json.h"
#include "trust/trust_meter.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;

constexpr char kReportScript[] = "trust_report.py";

struct TrustArguments {
  std::vector<std::string> folders, gaps, scenes;
  std::string out = "trust";
  int jobs = 1;
  bool resume = false, tables = true;
  TrustPlan plan;
  PipelineArguments pipeline;
};

po::options_description describe(TrustArguments& trust, const Arguments& arguments) {
  po::options_description options("Options");
  auto add = options.add_options();
  add("help,h", "this text");
  add("scenes", po::value(&trust.scenes)->composing(),
      "drawn scenes, by name or the beginning of names, with commas between; drawn: all of them");
  add("list-scenes", "names the drawn scenes and ends");
  add("pairs", po::value(&trust.plan.drawn_pairs)->default_value(trust.plan.drawn_pairs), "of each drawn scene");
  add("gaps", po::value(&trust.gaps)->composing(),
      "frames between reference and current of the sets, with commas between; default 1");
  add("stride", po::value(&trust.plan.stride)->default_value(trust.plan.stride),
      "frames between one pair and the next");
  add("truth-rotation-sigma", po::value<double>(),
      "noise of the sets' true rotation from image to image, degrees for each axis; default: by the kind of the set");
  add("truth-translation-sigma", po::value<double>(), "of their true translation, metres for each axis");
  add("truth-clock-sigma", po::value<double>(), "of the images' stamps against those of the truth, seconds");
  add("truth-alignment-sigma", po::value<double>(),
      "of the truth's axes against those of the camera, degrees about each");
  add("out,o", po::value(&trust.out)->default_value(trust.out), "folder for pairs.csv, trust.md, tables and plots");
  add("resume", po::bool_switch(&trust.resume), "go on with what is in the folder already");
  add("jobs,j", po::value(&trust.jobs)->default_value(trust.jobs), "pieces of work side by side");
  add("no-report", "only pairs.csv");
  addDatasetOptions(options, trust.plan.dataset);
  trust.pipeline.addTo(options, arguments);
  return options;
}

std::string sceneList() {
  std::string text;
  for (const DrawnScene& scene : drawnScenes()) text += scene.name + "\n    " + scene.summary + "\n";
  return text;
}

/// The scenes that a list asks for, in the order of the catalogue.
std::vector<std::string> chosenScenes(const std::vector<std::string>& lists) {
  std::set<std::string> wanted;
  for (const std::string& list : lists) {
    for (const std::string& word : splitAtCommas(list)) {
      const size_t before = wanted.size();
      for (const DrawnScene& scene : drawnScenes()) {
        if (word == "drawn" || scene.name.compare(0, word.size(), word) == 0) wanted.insert(scene.name);
      }
      if (wanted.size() == before) {
        throw std::invalid_argument("--scenes holds '" + word +
                                    "', with which no scene's name begins; see --list-scenes");
      }
    }
  }
  std::vector<std::string> names;
  for (const DrawnScene& scene : drawnScenes()) {
    if (wanted.count(scene.name) > 0) names.push_back(scene.name);
  }
  return names;
}

/// The value of an option, times `factor`.
std::optional<double> sigma(const po::variables_map& given, const char* option, double factor) {
  if (given.count(option) == 0) return std::nullopt;
  const double value = given[option].as<double>();
  if (!(value >= 0)) throw std::invalid_argument(std::string("--") + option + " must not be negative");
  return factor * value;
}

std::vector<TrustSet> chosenSets(const std::vector<std::string>& folders, const po::variables_map& given) {
  const std::optional<double> rotation = sigma(given, "truth-rotation-sigma", M_PI / 180);
  const std::optional<double> translation = sigma(given, "truth-translation-sigma", 1);
  const std::optional<double> clock = sigma(given, "truth-clock-sigma", 1);
  const std::optional<double> alignment = sigma(given, "truth-alignment-sigma", M_PI / 180);
  std::vector<TrustSet> sets;
  for (const std::string& folder : folders) {
    for (const std::string& path : setsIn(folder)) {
      const TruthNoise kind = defaultTruthNoise(path);
      sets.push_back({path,
                      {rotation.value_or(kind.rotation), translation.value_or(kind.translation),
                       clock.value_or(kind.clock), alignment.value_or(kind.alignment)}});
    }
  }
  return sets;
}

/// False when only a text was asked for.
bool parse(const Arguments& arguments, TrustArguments& trust) {
  const po::options_description options = describe(trust, arguments);
  const char* usage =
      "evaluate trust [DIR...] [--scenes drawn] [options]\n\nDIR: a set with truth, as for evaluate run, or a folder "
      "of "
      "such sets. Every method without --method.";
  const auto words =
      parseCommandLine(arguments, usage, options, {{"folder", -1, po::value(&trust.folders)}}, parseOldOption);
  if (!words) return false;
  const po::variables_map& given = *words;
  if (given.count("list-scenes")) {
    std::cout << sceneList();
    return false;
  }
  trust.tables = given.count("no-report") == 0;
  TrustPlan& plan = trust.plan;
  requireAtLeastOne({{"--pairs", plan.drawn_pairs}, {"--stride", plan.stride}, {"--jobs", trust.jobs}});
  if (!trust.gaps.empty()) plan.gaps.clear();
  for (const std::string& list : trust.gaps) {
    for (const int gap : parsePositives(list, "--gaps")) plan.gaps.push_back(gap);
  }
  plan.scenes = chosenScenes(trust.scenes);
  plan.sets = chosenSets(trust.folders, given);
  if (plan.sets.empty() && plan.scenes.empty()) {
    throw std::invalid_argument("neither a folder nor --scenes given; see evaluate trust --help");
  }
  std::vector<std::string> names = parseMethodNames(trust.pipeline.methods);
  if (names.empty()) {
    for (const MethodEntry& method : methods()) names.push_back(method.name);
  }
  for (const std::string& name : names) plan.pipelines.push_back(trust.pipeline.options(name));
  return true;
}

void reportTrust(const WorkFolder& folder, bool with_tables) {
  const std::vector<std::string> runs = folder.read();
  if (runs.empty()) return;
  const std::string path = folder.path() + "/pairs.csv";
  std::ofstream file(path);
  if (!(file << trustCsv(runs)).flush()) throw std::runtime_error(path + ": cannot be written");
  file.close();
  if (with_tables) runScript(kReportScript, folder.path(), "no tables and plots, but pairs.csv is complete");
}

}  // namespace

int evaluateTrust(const Arguments& arguments) {
  TrustArguments trust;
  if (!parse(arguments, trust)) return 0;
  std::vector<std::string> notes;
  const std::vector<TrustUnit> units = trustUnits(trust.plan, notes);
  for (const std::string& note : notes) std::cerr << note << '\n';
  WorkFolder folder(trust.out);
  folder.begin(planText(trust.plan), trust.resume);
  std::vector<int> numbers;
  numbers.reserve(units.size());
  for (const TrustUnit& unit : units) numbers.push_back(unit.index);
  const auto measure = [&](int index) { return runsText(measureTrust(trust.plan, units[static_cast<size_t>(index)])); };
  const InterruptWatch watch;
  workThrough(folder, numbers, trust.jobs, measure);
  reportTrust(folder, trust.tables);
  return statusOrInterrupted(0);
}

}  // namespace gms_ransac
