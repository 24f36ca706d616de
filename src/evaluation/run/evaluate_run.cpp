// `evaluate run` and `evaluate trust`: records of pairs of sets and of drawn scenes. `run` goes through them in order
// and prints a table; `trust` measures pieces side by side in a folder, and its reporter holds the answers against what
// they say of themselves.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <set>
#include <stdexcept>
#include <utility>

#include "run/evaluate_commands.h"
#include "run/record.h"
#include "run/truth.h"
#include "run/work_folder.h"

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;
using nlohmann::json;

/// Neighbouring pairs share images: enough of them to extract few images twice, few enough to spread over cores.
constexpr size_t kPairsOfPiece = 24;

/// Sets and scenes to be measured, and by which pipelines.
struct Plan {
  std::vector<MeasuredSet> sets;
  std::vector<int> gaps = {1};
  int stride = 1;
  std::vector<DrawnScene> scenes;
  int drawn_pairs = 100;  ///< of each scene
  Pipelines pipelines;    ///< one for each method
};

/// The scenes that lists ask for, in the order of the catalogue.
std::vector<DrawnScene> chosenScenes(const std::vector<std::string>& lists) {
  const std::vector<std::string> words = splitAtCommas(lists);
  std::set<std::string> unknown(words.begin(), words.end());
  std::vector<DrawnScene> scenes;
  for (const DrawnScene& scene : drawnScenes()) {
    const auto asks = [&](const std::string& word) { return word == "drawn" || scene.name.rfind(word, 0) == 0; };
    if (std::any_of(words.begin(), words.end(), asks)) scenes.push_back(scene);
    for (const std::string& word : words) {
      if (asks(word)) unknown.erase(word);
    }
  }
  if (unknown.empty()) return scenes;
  throw std::invalid_argument("--scenes holds '" + *unknown.begin() +
                              "', with which no scene's name begins; see --list-scenes");
}

/// The sets that a folder is or holds: itself, or its subfolders in the order of their names, with the images of
/// KITTI's right camera where they are there.
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

/// Parses `more` options and those of a plan, and opens the sets. False when only a text was asked for.
bool parse(const Arguments& arguments, const char* usage, const po::options_description& more,
           const std::vector<std::string>& methods, Plan& plan) {
  std::vector<std::string> folders, gaps, scenes;
  std::vector<std::pair<double TruthNoise::*, double>> sigmas;  // that are given
  DatasetOptions dataset_options;
  PipelineArguments pipeline;
  po::options_description options;
  auto add = options.add_options();
  const auto addSigma = [&](const std::string& option, double unit, double TruthNoise::*field, const char* text) {
    const auto take = [=, &sigmas](double value) {
      if (!(value >= 0)) throw std::invalid_argument("--" + option + " must not be negative");
      sigmas.emplace_back(field, unit * value);
    };
    add(option.c_str(), po::value<double>()->notifier(take), text);
  };
  add("gaps", po::value(&gaps)->composing(),
      "frames between reference and current of the sets, with commas between; default 1 (--gap 5 is enough)");
  add("stride", withDefault(plan.stride), "frames between one pair and the next");
  add("scenes", po::value(&scenes)->composing(),
      "drawn scenes, by name or the beginning of names, with commas between; drawn: all of them");
  add("list-scenes", "names the drawn scenes and ends");
  add("pairs", withDefault(plan.drawn_pairs), "of each drawn scene");
  addSigma(
      "truth-rotation-sigma", 1 / kDegrees, &TruthNoise::rotation,
      "noise of the sets' true rotation from image to image, degrees for each axis; default: by the kind of the set");
  addSigma("truth-translation-sigma", 1, &TruthNoise::translation, "of their true translation, metres for each axis");
  addSigma("truth-clock-sigma", 1, &TruthNoise::clock, "of the images' stamps against those of the truth, seconds");
  addSigma("truth-alignment-sigma", 1 / kDegrees, &TruthNoise::alignment,
           "of the truth's axes against those of the camera, degrees about each");
  for (const auto& option : more.options()) options.add(option);
  addDatasetOptions(options, dataset_options);
  pipeline.addTo(options, arguments);
  const auto given = parseCommandLine(arguments, usage, options, {{"folder", -1, po::value(&folders)}});
  if (!given) return false;
  if (given->count("list-scenes")) {
    for (const DrawnScene& scene : drawnScenes()) std::cout << scene.name << "\n    " << scene.summary << '\n';
    return false;
  }
  requireAtLeastOne({{"--pairs", plan.drawn_pairs}, {"--stride", plan.stride}});
  if (!gaps.empty()) plan.gaps = parsePositives(gaps, "--gaps");
  plan.pipelines = pipeline.pipelines(methods);
  plan.scenes = chosenScenes(scenes);
  for (const std::string& folder : folders) {
    for (const std::string& path : setsIn(folder)) {
      TruthNoise noise = defaultTruthNoise(path);
      for (const auto& [field, sigma] : sigmas) noise.*field = sigma;
      plan.sets.push_back({Dataset::open(path, dataset_options), noise});
    }
  }
  if (plan.sets.empty() && plan.scenes.empty()) {
    throw std::invalid_argument("neither a folder nor --scenes given; see --help");
  }
  return true;
}

/// In order: set, gap; then scenes. Says on stderr what the user should know of the sets.
std::vector<Series> seriesOf(const Plan& plan, bool correspondences) {
  std::vector<Series> all;
  for (const MeasuredSet& set : plan.sets) {
    printRemarks(set.dataset, plan.pipelines.front());
    const bool listed = set.dataset.kind() == DatasetKind::kImagePairs;
    for (const int gap : listed ? std::vector<int>{1} : plan.gaps) {
      all.push_back(pairSeries(set, gap, plan.stride, plan.pipelines, correspondences));
    }
  }
  for (const DrawnScene& scene : plan.scenes) all.push_back(drawnSeries(scene, plan.drawn_pairs, plan.pipelines));
  return all;
}

/// Everything that decides the figures, for telling whether two folders of measurements belong together.
json planRecord(const Plan& plan) {
  json record = {{"format", kRecordFormat},
                 {"gaps", plan.gaps},
                 {"stride", plan.stride},
                 {"drawn_pairs", plan.drawn_pairs},
                 {"options", optionsRecord(plan.pipelines.front())}};
  record["scenes"] = record["sets"] = record["methods"] = json::array();
  for (const DrawnScene& scene : plan.scenes) record["scenes"].push_back(scene.name);
  for (const MeasuredSet& set : plan.sets) {
    record["sets"].push_back({{"name", set.dataset.name()},
                              {"truth_rotation_sigma_deg", kDegrees * set.noise.rotation},
                              {"truth_translation_sigma_m", set.noise.translation},
                              {"truth_clock_sigma_s", set.noise.clock},
                              {"truth_alignment_sigma_deg", kDegrees * set.noise.alignment}});
  }
  for (const MatchFilterOptions& pipeline : plan.pipelines) record["methods"].push_back(pipeline.method);
  return record;
}

}  // namespace

int evaluateRun(const Arguments& arguments) {
  std::string out, plot;
  int repeats = 1;
  po::options_description options;
  auto add = options.add_options();
  add("repeat", withDefault(repeats), "repetitions, each with the next seed");
  add("out,o", po::value(&out), "file for the records, one JSON object a line; - for standard output");
  add("plot", po::value(&plot), "file for a plot (.png, .pdf) of errors and inliers over time");
  const char* usage =
      "evaluate run [SET...] [--scenes NAMES] [options]\n\nSET: a TUM or KITTI odometry folder, a folder of image "
      "pairs "
      "(pairs.txt), a .bag, or a folder\nof such sets. Writes a record for each pair and method, and prints a table.";
  Plan plan;
  if (!parse(arguments, usage, options, {}, plan)) return 0;
  requireAtLeastOne({{"--repeat", repeats}});
  const Pipelines methods = std::exchange(plan.pipelines, {});
  for (const MatchFilterOptions& method : methods) {
    for (int repeat = 0; repeat < repeats; ++repeat) {
      plan.pipelines.push_back(method);
      plan.pipelines.back().robust.seed += static_cast<uint64_t>(repeat);
    }
  }
  std::vector<std::string> report = {"run"};
  if (!plot.empty()) report.insert(report.end(), {"--plot", plot});
  const std::vector<Series> all = seriesOf(plan, !out.empty());
  Reporter reporter(report, out);
  return stream(all, "pair", reporter);
}

int evaluateTrust(const Arguments& arguments) {
  WorkFolder folder = {"trust", kPairsOfPiece};
  bool no_report = false;
  po::options_description options;
  folder.addTo(options);
  auto add = options.add_options();
  add("jobs,j", withDefault(folder.jobs), "pieces of work side by side");
  add("no-report", po::bool_switch(&no_report), "only records and pairs.csv");
  const char* usage =
      "evaluate trust [SET...] [--scenes drawn] [options]\n\nSET: with truth, as for evaluate run, or a folder of such "
      "sets. Without --method lo_prosac and cp_ransac; --method all has every method.";
  Plan plan;
  if (!parse(arguments, usage, options, {"lo_prosac", "cp_ransac"}, plan)) return 0;
  requireAtLeastOne({{"--jobs", folder.jobs}});
  std::vector<std::string> report = {"trust", folder.path};
  if (no_report) report.emplace_back("--no-tables");
  return workThrough(folder, planRecord(plan), seriesOf(plan, false), report);
}

}  // namespace gms_ransac
