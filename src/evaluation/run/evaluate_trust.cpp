// `evaluate trust`: answers on sets with truth and on drawn scenes. The reporter counts wrong answers among the OK
// ones, and checks covariances and match probabilities against the truth.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <utility>

#include "run/evaluate_commands.h"
#include "run/experiment.h"
#include "run/work_folder.h"
#include "scenes/drawn_scenes.h"

namespace gms_ransac {

namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;
using nlohmann::json;

/// Neighbouring pairs share images: enough of them to extract few images twice, few enough to spread over cores.
constexpr size_t kPairsOfUnit = 24;
constexpr size_t kPairsBefore = 4;  ///< that give a unit its past, times the gap

struct TrustSet {
  Dataset dataset;
  TruthNoise noise;
};

struct TrustPlan {
  std::vector<TrustSet> sets;
  std::vector<int> gaps = {1};
  int stride = 1;
  std::vector<DrawnScene> scenes;
  int drawn_pairs = 100;                      ///< of each scene
  std::vector<MatchFilterOptions> pipelines;  ///< one for each method
  WorkFolder folder = {"trust"};
  int jobs = 1;
  std::vector<std::string> report;  ///< arguments of the reporter
};

/// The scenes that lists ask for, in the order of the catalogue.
std::vector<DrawnScene> chosenScenes(const std::vector<std::string>& lists) {
  const auto asked = [](const DrawnScene& scene, const std::string& word) {
    return word == "drawn" || scene.name.compare(0, word.size(), word) == 0;
  };
  const std::vector<std::string> words = splitAtCommas(lists);
  const std::vector<DrawnScene>& all = drawnScenes();
  for (const std::string& word : words) {
    if (std::any_of(all.begin(), all.end(), [&](const DrawnScene& scene) { return asked(scene, word); })) continue;
    throw std::invalid_argument("--scenes holds '" + word + "', with which no scene's name begins; see --list-scenes");
  }
  std::vector<DrawnScene> scenes;
  std::copy_if(all.begin(), all.end(), std::back_inserter(scenes), [&](const DrawnScene& scene) {
    return std::any_of(words.begin(), words.end(), [&](const std::string& word) { return asked(scene, word); });
  });
  return scenes;
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

/// False when only a text was asked for.
bool parse(const Arguments& arguments, TrustPlan& plan) {
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
  add("scenes", po::value(&scenes)->composing(),
      "drawn scenes, by name or the beginning of names, with commas between; drawn: all of them");
  add("list-scenes", "names the drawn scenes and ends");
  add("pairs", withDefault(plan.drawn_pairs), "of each drawn scene");
  add("gaps", po::value(&gaps)->composing(),
      "frames between reference and current of the sets, with commas between; default 1");
  add("stride", withDefault(plan.stride), "frames between one pair and the next");
  addSigma(
      "truth-rotation-sigma", 1 / kDegrees, &TruthNoise::rotation,
      "noise of the sets' true rotation from image to image, degrees for each axis; default: by the kind of the set");
  addSigma("truth-translation-sigma", 1, &TruthNoise::translation, "of their true translation, metres for each axis");
  addSigma("truth-clock-sigma", 1, &TruthNoise::clock, "of the images' stamps against those of the truth, seconds");
  addSigma("truth-alignment-sigma", 1 / kDegrees, &TruthNoise::alignment,
           "of the truth's axes against those of the camera, degrees about each");
  add("out,o", withDefault(plan.folder.path), "folder for records, pairs.csv, trust.md and plots");
  add("resume", po::bool_switch(&plan.folder.resume), "go on with what is in the folder already");
  add("jobs,j", withDefault(plan.jobs), "pieces of work side by side");
  add("no-report", "only records and pairs.csv");
  addDatasetOptions(options, dataset_options);
  pipeline.addTo(options, arguments);
  const char* usage =
      "evaluate trust [DIR...] [--scenes drawn] [options]\n\nDIR: a set with truth, as for evaluate run, or a folder "
      "of such sets. Without --method lo_prosac and cp_ransac; --method all has every method.";
  const auto given = parseCommandLine(arguments, usage, options, {{"folder", -1, po::value(&folders)}});
  if (!given) return false;
  if (given->count("list-scenes")) {
    for (const DrawnScene& scene : drawnScenes()) std::cout << scene.name << "\n    " << scene.summary << '\n';
    return false;
  }
  plan.report = {"trust", plan.folder.path};
  if (given->count("no-report")) plan.report.push_back("--no-tables");
  requireAtLeastOne({{"--pairs", plan.drawn_pairs}, {"--stride", plan.stride}, {"--jobs", plan.jobs}});
  if (!gaps.empty()) plan.gaps = parsePositives(gaps, "--gaps");
  plan.scenes = chosenScenes(scenes);
  for (const std::string& folder : folders) {
    for (const std::string& path : setsIn(folder)) {
      TruthNoise noise = defaultTruthNoise(path);
      for (const auto& [field, sigma] : sigmas) noise.*field = sigma;
      plan.sets.push_back({Dataset::open(path, dataset_options), noise});
    }
  }
  if (plan.sets.empty() && plan.scenes.empty()) {
    throw std::invalid_argument("neither a folder nor --scenes given; see evaluate trust --help");
  }
  plan.pipelines = pipeline.pipelines({"lo_prosac", "cp_ransac"});
  return true;
}

/// Everything that decides the figures, for telling whether two folders of measurements belong together.
json planRecord(const TrustPlan& plan) {
  json record = {{"format", kRecordFormat},
                 {"gaps", plan.gaps},
                 {"stride", plan.stride},
                 {"drawn_pairs", plan.drawn_pairs},
                 {"options", optionsRecord(plan.pipelines.front())}};
  record["scenes"] = record["sets"] = record["methods"] = json::array();
  for (const DrawnScene& scene : plan.scenes) record["scenes"].push_back(scene.name);
  for (const TrustSet& set : plan.sets) {
    record["sets"].push_back({{"name", set.dataset.name()},
                              {"truth_rotation_sigma_deg", kDegrees * set.noise.rotation},
                              {"truth_translation_sigma_m", set.noise.translation},
                              {"truth_clock_sigma_s", set.noise.clock},
                              {"truth_alignment_sigma_deg", kDegrees * set.noise.alignment}});
  }
  for (const MatchFilterOptions& pipeline : plan.pipelines) record["methods"].push_back(pipeline.method);
  return record;
}

/// Neighbouring pairs of a set, kPairsOfUnit at most; `gap` 0: of a list of pairs.
json measureSet(const TrustPlan& plan, const TrustSet& set, int gap, size_t first) {
  const std::vector<DatasetPair> pairs = set.dataset.pairs(std::max(1, gap), plan.stride);
  Experiment experiment(set.dataset, plan.pipelines, set.noise);
  json records = json::array();
  const size_t before = std::min(first, kPairsBefore * static_cast<size_t>(gap));
  for (size_t i = first - before; i < std::min(pairs.size(), first + kPairsOfUnit); ++i) {
    experiment.run(pairs[i], gap, [&](json& record, const Answer&) {
      if (i >= first) records.push_back(std::move(record));
    });
  }
  return records;
}

json measureScene(const TrustPlan& plan, const DrawnScene& drawn) {
  std::vector<std::unique_ptr<Method>> methods;
  for (const MatchFilterOptions& pipeline : plan.pipelines) methods.push_back(makeMethod(pipeline));
  json records = json::array();
  for (int i = 0; i < plan.drawn_pairs; ++i) {
    const TwoViewScene scene = drawPair(drawn, i);
    for (size_t m = 0; m < methods.size(); ++m) {
      json& record = records.emplace_back(recordOf(plan.pipelines[m], *methods[m], scene));
      record.update({{"set", drawn.name}, {"reference", ""}, {"current", std::to_string(i)}});
      record["gap"] = record["stamp"] = nullptr;
    }
  }
  return records;
}

/// In order: set, gap, pairs; then scenes. Says on stderr what the user should know of the sets.
WorkUnits trustUnits(const TrustPlan& plan) {
  WorkUnits units;
  int number = 0;
  for (const TrustSet& set : plan.sets) {
    printRemarks(set.dataset, plan.pipelines.front());
    const bool listed = set.dataset.kind() == DatasetKind::kImagePairs;
    for (const int gap : listed ? std::vector<int>{0} : plan.gaps) {
      const size_t pairs = set.dataset.pairs(std::max(1, gap), plan.stride).size();
      if (pairs == 0) std::cerr << set.dataset.name() << " has no images " << gap << " apart\n";
      for (size_t first = 0; first < pairs; first += kPairsOfUnit) {
        const std::string name = set.dataset.name() + (listed ? "" : ", gap " + std::to_string(gap));
        units[number++] = {name, [&plan, &set, gap, first] { return measureSet(plan, set, gap, first); }};
      }
    }
  }
  for (const DrawnScene& scene : plan.scenes) {
    units[number++] = {scene.name, [&plan, &scene] { return measureScene(plan, scene); }};
  }
  return units;
}

}  // namespace

int evaluateTrust(const Arguments& arguments) {
  TrustPlan plan;
  if (!parse(arguments, plan)) return 0;
  return workThrough(plan.folder, planRecord(plan), trustUnits(plan), plan.jobs, plan.report);
}

}  // namespace gms_ransac
