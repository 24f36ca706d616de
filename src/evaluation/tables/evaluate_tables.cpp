// `evaluate tables` and `evaluate merge`: the paper's tables on one's own images, in pieces that can be interrupted,
// resumed and spread over machines.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <stdexcept>

#include <boost/program_options.hpp>

#include "program.h"
#include "run/evaluate_commands.h"
#include "run/experiment.h"
#include "run/pipeline_options.h"
#include "run/work_folder.h"
#include "tables/tables_json.h"
#include "tables/tables_measure.h"

namespace gms_ransac {

namespace {

namespace po = boost::program_options;

constexpr int kNoTables = 1;  // exit status

/// Share i of n of the work, i from 1.
struct Shard {
  int index = 1, count = 1;
  bool owns(const TablesUnit& unit) const { return unit.index % count == index - 1; }
};

struct TablesArguments {
  std::vector<std::string> folders, ratios;
  std::string out = "tables", shard = "1/1", presets;
  bool resume = false, plots = true;
  TablesPlan plan;
  DatasetOptions dataset;
  PipelineArguments pipeline;
};

Shard parseShard(const std::string& text) {
  Shard shard;
  char end = 0;
  if (std::sscanf(text.c_str(), "%d/%d%c", &shard.index, &shard.count, &end) != 2 || shard.index < 1 ||
      shard.count < shard.index) {
    throw std::invalid_argument("--shard is '" + text + "'; it must look like 2/5, from 1/5 to 5/5");
  }
  return shard;
}

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

po::options_description describe(TablesArguments& tables, const Arguments& arguments) {
  tables.pipeline.base.extractor.extractor = "opencv";  // what the paper used
  tables.pipeline.base.one_to_one = false;              // likewise
  po::options_description options("Options");
  auto add = options.add_options();
  add("help,h", "this text");
  add("out,o", po::value(&tables.out)->default_value(tables.out), "folder for measurements, tables and plots");
  add("resume", po::bool_switch(&tables.resume), "go on with what is in the folder already");
  add("shard", po::value(&tables.shard)->default_value(tables.shard), "i/n: do the i-th of n parts (see merge)");
  add("gap", po::value(&tables.plan.gap)->default_value(tables.plan.gap), "frames between reference and current");
  add("pairs", po::value(&tables.plan.pairs)->default_value(tables.plan.pairs), "pairs a set, spread evenly over it");
  add("repeat", po::value(&tables.plan.repeats)->default_value(tables.plan.repeats), "seeds for each pair");
  add("presets", po::value(&tables.presets), "numbers of features, separated by commas; default: the paper's twelve");
  add("ratios", po::value<std::string>(), "grouping ratios, separated by commas; default: the paper's seven");
  add("no-plots", "only CSV and Markdown");
  addDatasetOptions(options, tables.dataset);
  tables.pipeline.addTo(options, arguments);
  return options;
}

/// Methods beside cp_ransac: those asked for, else the paper's two baselines and the package's own.
std::vector<std::string> comparedMethods(const PipelineArguments& pipeline) {
  std::vector<std::string> wanted = parseMethodNames(pipeline.methods);
  if (wanted.empty()) {
    for (const MethodEntry& method : methods()) {
      const std::string name = method.name;
      if (name == "gms_ransac" || name == "lan" || name == "lo_prosac") wanted.push_back(name);
    }
  }
  std::vector<std::string> others;
  for (const std::string& name : wanted) {
    if (name != "cp_ransac") others.push_back(name);
  }
  return others;
}

/// False when only help was asked for.
bool parse(const Arguments& arguments, TablesArguments& tables) {
  const po::options_description options = describe(tables, arguments);
  const char* usage =
      "evaluate tables DIR... [options]\n\nMakes the paper's Tables 1-5 and the data of its Figures 5, 6, 8 and 9 on "
      "each set.\nOptions of the pipeline hold for every method.";
  const auto words =
      parseCommandLine(arguments, usage, options, {{"folder", -1, po::value(&tables.folders)}}, parseOldOption);
  if (!words) return false;
  const po::variables_map& given = *words;
  if (tables.folders.empty()) throw std::invalid_argument("no folder or bag given; see evaluate tables --help");
  for (const char* fixed : {"features", "first-group-fraction"}) {
    if (!given[fixed].defaulted()) {
      throw std::invalid_argument(std::string("--") + fixed +
                                  " is varied by the tables; choose --presets and --ratios");
    }
  }
  TablesPlan& plan = tables.plan;
  requireAtLeastOne({{"--gap", plan.gap}, {"--pairs", plan.pairs}, {"--repeat", plan.repeats}});
  if (!tables.presets.empty()) plan.presets = parsePositives(tables.presets, "--presets");
  if (given.count("ratios")) {
    plan.ratios.clear();
    for (const std::string& text : splitAtCommas(given["ratios"].as<std::string>())) {
      plan.ratios.push_back(parseRatio(text));
    }
  }
  tables.plots = given.count("no-plots") == 0;
  plan.base = tables.pipeline.options("cp_ransac");
  plan.model = plan.base.robust.model;
  plan.methods = comparedMethods(tables.pipeline);
  return true;
}

std::vector<Dataset> openAll(const TablesArguments& tables) {
  std::vector<Dataset> datasets;
  std::set<std::string> names;
  for (const std::string& folder : tables.folders) {
    datasets.push_back(Dataset::open(folder, tables.dataset));
    if (!names.insert(datasets.back().name()).second) {
      throw std::invalid_argument("two sets are called " + datasets.back().name() + "; their names tell them apart");
    }
    if (datasets.back().pairs(tables.plan.gap, 1).empty()) {
      throw std::invalid_argument(folder + ": no pair of images " + std::to_string(tables.plan.gap) + " apart");
    }
    if (const auto note = unappliedOption(datasets.back(), tables.plan.base)) std::cerr << *note << '\n';
  }
  return datasets;
}

/// Tables and plots of everything the folder holds. Returns the exit status.
int reportTables(const WorkFolder& folder, bool plots) {
  if (folder.unitsDone() == 0) return 0;
  if (!runScript("tables_report.py", folder.path(), "no tables, but the measurements are complete")) return kNoTables;
  if (plots) plotTables(folder.path());
  return 0;
}

}  // namespace

int evaluateTables(const Arguments& arguments) {
  TablesArguments tables;
  if (!parse(arguments, tables)) return 0;
  const Shard shard = parseShard(tables.shard);
  const std::vector<Dataset> datasets = openAll(tables);
  for (const Dataset& dataset : datasets) tables.plan.sequences.push_back(dataset.name());

  WorkFolder folder(tables.out);
  folder.begin(planText(tables.plan), tables.resume);
  const std::vector<TablesUnit> units = tablesUnits(tables.plan, datasets);
  std::vector<int> numbers;
  for (const TablesUnit& unit : units) {
    if (shard.owns(unit)) numbers.push_back(unit.index);
  }
  TablesMeter meter(tables.plan, datasets);
  const auto measure = [&](int index) { return runsText(meter.measure(units[static_cast<size_t>(index)])); };
  const InterruptWatch watch;
  workThrough(folder, numbers, 1, measure);  // one at a time, for the times' sake
  return statusOrInterrupted(reportTables(folder, tables.plots));
}

int evaluateMerge(const Arguments& arguments) {
  std::string out = "tables";
  std::vector<std::string> parts;
  po::options_description options("Options");
  options.add_options()("help,h", "this text")("out,o", po::value(&out)->default_value(out), "folder to write")(
      "no-plots", "only CSV and Markdown");
  const char* usage =
      "evaluate merge PART... --out FOLDER\n\nJoins the folders that evaluate tables --shard i/n wrote with the same "
      "options, and makes\nthe tables of all.";
  const auto given = parseCommandLine(arguments, usage, options, {{"part", -1, po::value(&parts)}});
  if (!given) return 0;
  if (parts.empty()) throw std::invalid_argument("no folder to merge given; see evaluate merge --help");
  WorkFolder merged(out);
  for (size_t i = 0; i < parts.size(); ++i) {
    WorkFolder part(parts[i]);
    part.open();
    if (i == 0) merged.begin(part.plan(), false);
    merged.absorb(part);
  }
  return reportTables(merged, given->count("no-plots") == 0);
}

}  // namespace gms_ransac
