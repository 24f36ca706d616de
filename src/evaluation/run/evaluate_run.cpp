// `evaluate run`, `trust` and `sweep`: records of pairs of sets and of drawn scenes. `run` and `sweep` go through them
// in order and print a table; `trust` measures pieces side by side in a folder.
#include <algorithm>
#include <fstream>
#include <iostream>
#include <set>
#include <stdexcept>
#include <utility>

#include "run/evaluate_commands.h"
#include "run/record.h"
#include "run/work_folder.h"

namespace gms_ransac {

namespace {

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
  std::vector<DrawnSequence> sequences;
  int drawn_pairs = 100;  ///< of each scene
  Pipelines pipelines;    ///< one for each method
};

/// Those of a catalogue whose names begin with one of the words, in its order; takes these words out of `unknown`.
template <class Scene>
std::vector<Scene> chosenOf(const std::vector<Scene>& catalogue, const std::vector<std::string>& words,
                            std::set<std::string>& unknown) {
  std::vector<Scene> chosen;
  for (const Scene& scene : catalogue) {
    const auto asks = [&](const std::string& word) {
      const bool wanted = word == "drawn" || scene.name.rfind(word, 0) == 0;
      if (wanted) unknown.erase(word);
      return wanted;
    };
    if (std::count_if(words.begin(), words.end(), asks) > 0) chosen.push_back(scene);
  }
  return chosen;
}

/// The scenes and sequences that lists ask for.
void chooseScenes(const std::vector<std::string>& lists, Plan& plan) {
  const std::vector<std::string> words = splitAtCommas(lists);
  std::set<std::string> unknown(words.begin(), words.end());
  plan.scenes = chosenOf(drawnScenes(), words, unknown);
  plan.sequences = chosenOf(drawnSequences(), words, unknown);
  if (unknown.empty()) return;
  throw std::invalid_argument("--scenes holds '" + *unknown.begin() +
                              "', with which no scene's name begins; see --list-scenes");
}

template <class Scene>
void list(const std::vector<Scene>& catalogue) {
  for (const Scene& scene : catalogue) std::cout << scene.name << "\n    " << scene.summary << '\n';
}

/// Parses the options of a command and those of a plan, and opens the sets. False when only a text was asked for.
bool parse(const Arguments& arguments, const char* usage, const std::vector<std::string>& methods, CommandLine& line,
           Plan& plan) {
  std::vector<std::string> gap, gaps, scenes;
  std::vector<std::pair<double TruthNoise::*, double>> sigmas;  // that are given
  auto add = line.options.add_options();
  const auto addSigma = [&](const std::string& option, double unit, double TruthNoise::*field, const char* text) {
    const auto store = [=, &sigmas](double value) {
      if (!(value >= 0)) throw std::invalid_argument("--" + option + " must not be negative");
      sigmas.emplace_back(field, unit * value);
    };
    add(option.c_str(), po::value<double>()->notifier(store), text);
  };
  add("gaps", po::value(&gaps)->composing(),
      "frames between reference and current of the sets, with commas between; default 1");
  add("gap", po::value(&gap)->composing(), "the same");
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
  if (!line.parse(arguments, usage)) return false;
  if (line.given("list-scenes")) {
    list(drawnScenes());
    list(drawnSequences());
    return false;
  }
  requireAtLeastOne({{"--pairs", plan.drawn_pairs}, {"--stride", plan.stride}});
  gaps.insert(gaps.end(), gap.begin(), gap.end());
  if (!gaps.empty()) plan.gaps = parsePositives(gaps, "--gaps");
  plan.pipelines = line.pipelines(methods);
  chooseScenes(scenes, plan);
  plan.sets = line.sets();
  for (MeasuredSet& set : plan.sets) {
    for (const auto& [field, sigma] : sigmas) set.noise.*field = sigma;
  }
  if (!plan.sets.empty() || !plan.scenes.empty() || !plan.sequences.empty()) return true;
  throw std::invalid_argument("neither a folder nor --scenes given; see --help");
}

/// In order: set, gap; then scenes.
std::vector<Series> seriesOf(const Plan& plan, bool correspondences) {
  std::vector<Series> all;
  for (const MeasuredSet& set : plan.sets) {
    const bool listed = set.dataset.kind() == DatasetKind::kImagePairs;
    for (const int gap : listed ? std::vector<int>{1} : plan.gaps) {
      all.push_back(pairSeries(set, gap, plan.stride, plan.pipelines, correspondences));
    }
  }
  for (const DrawnScene& scene : plan.scenes) all.push_back(drawnSeries(scene, plan.drawn_pairs, plan.pipelines));
  for (const DrawnSequence& sequence : plan.sequences) {
    all.push_back(sequenceSeries(sequence, plan.drawn_pairs, plan.pipelines));
  }
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
  for (const DrawnSequence& sequence : plan.sequences) record["scenes"].push_back(sequence.name);
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
  CommandLine line({"run"});
  Plan plan;
  std::string out;
  int repeats = 1;
  auto add = line.options.add_options();
  add("repeat", withDefault(repeats), "repetitions, each with the next seed");
  add("out,o", po::value(&out), "file for the records, one JSON object a line; - for standard output");
  line.addForReport("plot", "file for a plot (.png, .pdf) of errors and inliers over time; needs python3-matplotlib");
  const char* usage =
      "evaluate run [SET...] [--scenes NAMES] [options]\n\nSET: a TUM or KITTI odometry folder, a folder of image "
      "pairs (pairs.txt), a .bag, or a\nfolder of such sets. Writes a record for each pair and method, and prints a "
      "table.";
  if (!parse(arguments, usage, {}, line, plan)) return 0;
  requireAtLeastOne({{"--repeat", repeats}});
  const Pipelines methods = std::exchange(plan.pipelines, {});
  for (const MatchFilterOptions& method : methods) {
    for (int repeat = 0; repeat < repeats; ++repeat) {
      plan.pipelines.push_back(method);
      plan.pipelines.back().robust.seed += static_cast<uint64_t>(repeat);
    }
  }
  return stream(seriesOf(plan, !out.empty()), "pair", line.report, out);
}

int evaluateTrust(const Arguments& arguments) {
  WorkFolder folder = {"trust", kPairsOfPiece};
  CommandLine line({"trust"});
  Plan plan;
  bool no_report = false;
  folder.addTo(line.options);
  auto add = line.options.add_options();
  add("jobs,j", withDefault(folder.jobs), "pieces of work side by side");
  add("no-report", po::bool_switch(&no_report), "only records and pairs.csv");
  const char* usage =
      "evaluate trust [SET...] [--scenes drawn] [options]\n\nSET: with truth, as for evaluate run, or a folder of such "
      "sets. Without --method lo_prosac and cp_ransac; --method all has every method.";
  if (!parse(arguments, usage, {"lo_prosac", "cp_ransac"}, line, plan)) return 0;
  requireAtLeastOne({{"--jobs", folder.jobs}});
  line.report.push_back(folder.path);
  if (no_report) line.report.emplace_back("--no-tables");
  return workThrough(folder, planRecord(plan), seriesOf(plan, false), line.report);
}

/// How each method's estimator holds out against outliers, on drawn scenes with exact labels, whose scores and
/// distances tell right matches from wrong ones with overlap. There is no filter stage, so that the estimator meets the
/// given ratio: methods that differ only in the filter have equal results.
int evaluateSweep(const Arguments& arguments) {
  CommandLine line({"sweep"});
  int repeat = 50;
  std::string out;
  auto add = line.options.add_options();
  add("repeat", withDefault(repeat), "trials for each method and outlier ratio");
  add("out,o", po::value(&out), "file for the table, CSV, with the plot beside it; standard output without");
  line.addFlagForReport("no-plots", "only CSV");
  const char* usage =
      "evaluate sweep [options]\n\nSuccess rate and effort of each method's estimator at outlier ratios of 0.1 to 0.9, "
      "on correspondences of\ndrawn scenes. Success: rotation within 1 degree and direction within 5 degrees. Without "
      "--method all;\noptions of extraction, matching and filter have no effect.";
  if (!line.parse(arguments, usage, false)) return 0;
  const Pipelines pipelines = line.pipelines({"all"});
  if (pipelines.front().robust.model == ModelType::kHomography) {
    throw std::invalid_argument("--model is 'homography'; the scene is no plane: it must be essential or fundamental");
  }
  requireAtLeastOne({{"--repeat", repeat}});
  if (!out.empty()) line.report.insert(line.report.end(), {"--out", out});
  if (!out.empty() && !std::ofstream(out)) throw std::invalid_argument("cannot write " + out);
  std::vector<Series> all;
  for (const double ratio : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}) {
    all.push_back(outlierSeries(ratio, repeat, pipelines));
  }
  return stream(all, "trial", line.report);
}

}  // namespace gms_ransac
