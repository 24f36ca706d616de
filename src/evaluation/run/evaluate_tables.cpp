// `evaluate tables`: the paper's tables on one's own images, in pieces that can be interrupted, resumed and spread over
// machines.
#include <algorithm>
#include <set>
#include <stdexcept>

#include "run/evaluate_commands.h"
#include "run/record.h"
#include "run/work_folder.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;
using nlohmann::json;

constexpr double kPaperRatio = 0.5;  // the paper's default: the confident half
constexpr int kTable4Preset = 2000;
/// Presets above this get FAST threshold 0: with OpenCV's default of 20 a VGA image does not hold that many corners.
constexpr int kLastPresetOfDefaultFastThreshold = 3000;

struct TablesPlan {
  std::vector<MeasuredSet> sets;
  int gap = 1, pairs = 5, repeats = 20;
  std::vector<int> presets = {1000, 2000, 2500, 3000, 3500, 4000, 5000, 6000, 7000, 8000, 9000, 10000};
  std::vector<double> ratios = {1.0 / 5, 1.0 / 4, 1.0 / 3, 1.0 / 2, 2.0 / 3, 3.0 / 4, 4.0 / 5};
  std::vector<std::string> methods;  ///< compared with cp_ransac, always there
  MatchFilterOptions base;           ///< extractor, model, grid, threshold, seed, ... of every run
  WorkFolder folder = {"tables", 1};
  CommandLine line{{"tables"}};
};

/// "1/3" or "0.4".
double parseRatio(const std::string& text) {
  double numerator = 0, denominator = 1;
  char end = 0;
  const int fields = std::sscanf(text.c_str(), "%lf/%lf%c", &numerator, &denominator, &end);
  if (fields == 1 && text.find_first_not_of("0123456789.") != std::string::npos) numerator = 0;
  if (fields < 1 || fields > 2 || !(numerator > 0) || !(numerator <= denominator)) {
    throw std::invalid_argument("--ratios holds '" + text + "'; a ratio looks like 1/2 or 0.5 and is at most 1");
  }
  return numerator / denominator;
}

/// False when only help was asked for.
bool parse(const Arguments& arguments, TablesPlan& plan) {
  CommandLine& line = plan.line;
  std::string shard = "1/1", presets, ratios;
  line.base.extractor = MatchFilterOptions::paper().extractor;
  line.base.one_to_one = line.base.align_points = false;  // as in the paper
  line.base.search = SearchMode::kFull;                   // likewise
  plan.folder.addTo(line.options);
  auto add = line.options.add_options();
  add("shard", withDefault(shard), "i/n: do the i-th of n parts (see merge)");
  add("gap", withDefault(plan.gap), "frames between reference and current");
  add("pairs", withDefault(plan.pairs), "pairs a set, spread evenly over it");
  add("repeat", withDefault(plan.repeats), "seeds for each pair");
  add("presets", po::value(&presets), "numbers of features, separated by commas; default: the paper's twelve");
  add("ratios", po::value(&ratios), "grouping ratios, separated by commas; default: the paper's seven");
  line.addFlagForReport("no-plots", "only CSV and Markdown");
  const char* usage =
      "evaluate tables DIR... [options]\n\nMakes the paper's Tables 1-5 and the data of its Figures 5, 6, 8 and 9 on "
      "each set.\nOptions of the pipeline hold for every method.";
  if (!line.parse(arguments, usage)) return false;
  if (line.folders.empty()) throw std::invalid_argument("no folder or bag given; see evaluate tables --help");
  for (const char* fixed : {"features", "first-group-fraction"}) {
    if (!line.given(fixed)) continue;
    throw std::invalid_argument(std::string("--") + fixed + " is varied by the tables; choose --presets and --ratios");
  }
  requireAtLeastOne({{"--gap", plan.gap}, {"--pairs", plan.pairs}, {"--repeat", plan.repeats}});
  if (!presets.empty()) plan.presets = parsePositives({presets}, "--presets");
  if (line.given("ratios")) plan.ratios.clear();
  for (const std::string& text : splitAtCommas({ratios})) plan.ratios.push_back(parseRatio(text));
  char end = 0;
  if (std::sscanf(shard.c_str(), "%zu/%zu%c", &plan.folder.shard, &plan.folder.shards, &end) != 2 ||
      plan.folder.shard < 1 || plan.folder.shards < plan.folder.shard) {
    throw std::invalid_argument("--shard is '" + shard + "'; it must look like 2/5, from 1/5 to 5/5");
  }
  line.report.push_back(plan.folder.path);
  for (const MatchFilterOptions& method : line.pipelines({"lan", "gms_ransac", "lo_prosac"})) {
    plan.base = method;
    if (method.method != "cp_ransac") plan.methods.push_back(method.method);
  }
  plan.base.method = "cp_ransac";
  plan.sets = line.sets();
  std::set<std::string> names;
  for (const MeasuredSet& set : plan.sets) {
    if (!names.insert(set.dataset.name()).second) {
      throw std::invalid_argument("two sets are called " + set.dataset.name() + "; their names tell them apart");
    }
    if (set.dataset.pairs(plan.gap, 1).empty()) {
      throw std::invalid_argument(set.dataset.path() + ": no pair of images " + std::to_string(plan.gap) + " apart");
    }
  }
  return true;
}

/// Everything that decides the figures, for telling whether two folders of measurements belong together.
json planRecord(const TablesPlan& plan) {
  json record = {{"format", kRecordFormat},
                 {"gap", plan.gap},
                 {"pairs", plan.pairs},
                 {"repeats", plan.repeats},
                 {"presets", plan.presets},
                 {"ratios", plan.ratios},
                 {"methods", plan.methods},
                 {"threads", plan.base.extractor.threads},
                 {"options", optionsRecord(plan.base)}};
  for (const MeasuredSet& set : plan.sets) record["sequences"].push_back(set.dataset.name());
  return record;
}

/// cp_ransac at every ratio, every other method once, and at Table 4's preset the other models too.
Pipelines pipelinesOf(const TablesPlan& plan, int preset) {
  Pipelines pipelines;
  const auto add = [&](const std::string& method, ModelType model, double ratio) {
    MatchFilterOptions& options = pipelines.emplace_back(plan.base);
    options.method = method;
    options.robust.model = model;
    options.robust.first_group_fraction = ratio;
    options.extractor.features = preset;
    if (preset > kLastPresetOfDefaultFastThreshold) options.extractor.fast_threshold = 0;
  };
  for (const double ratio : plan.ratios) add("cp_ransac", plan.base.robust.model, ratio);
  for (const std::string& method : plan.methods) add(method, plan.base.robust.model, kPaperRatio);
  if (preset != kTable4Preset) return pipelines;
  for (const ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
    if (model == plan.base.robust.model) continue;
    add("cp_ransac", model, kPaperRatio);
    for (const std::string& method : plan.methods) add(method, model, kPaperRatio);
  }
  return pipelines;
}

}  // namespace

int evaluateTables(const Arguments& arguments) {
  TablesPlan plan;
  if (!parse(arguments, plan)) return 0;
  std::vector<Pipelines> pipelines;
  for (const int preset : plan.presets) pipelines.push_back(pipelinesOf(plan, preset));
  std::vector<Series> all;
  for (const MeasuredSet& set : plan.sets) {
    for (const Pipelines& of_preset : pipelines) {
      all.push_back(timedSeries(set, plan.gap, plan.pairs, of_preset, plan.repeats));
    }
  }
  return workThrough(plan.folder, planRecord(plan), all, plan.line.report);
}

}  // namespace gms_ransac
