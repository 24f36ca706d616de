// What `evaluate tables` measures: the paper's presets, ratios, methods and models over some pairs of some sequences.
#pragma once

#include <string>
#include <vector>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"

namespace gms_ransac {

/// The paper's default: the confident half.
constexpr double kPaperRatio = 0.5;
/// Preset of the paper's Table 4.
constexpr int kTable4Preset = 2000;
/// Presets above this get FAST threshold 0: with OpenCV's default of 20 a VGA image does not hold that many corners.
constexpr int kLastPresetOfDefaultFastThreshold = 3000;

struct TablesPlan {
  std::vector<std::string> sequences;  ///< names of the sets
  int gap = 1, pairs = 5, repeats = 20;
  std::vector<int> presets = {1000, 2000, 2500, 3000, 3500, 4000, 5000, 6000, 7000, 8000, 9000, 10000};
  std::vector<double> ratios = {1.0 / 5, 1.0 / 4, 1.0 / 3, 1.0 / 2, 2.0 / 3, 3.0 / 4, 4.0 / 5};
  std::vector<std::string> methods;  ///< compared with cp_ransac, which is always there
  ModelType model = ModelType::kEssential;
  MatchFilterOptions base;  ///< extractor, grid, threshold, seed, ... of every run
};

/// One piece of work: a pair of images at one preset.
struct TablesUnit {
  int index = 0;     ///< position in the plan, which orders the results
  int sequence = 0;  ///< into TablesPlan::sequences
  DatasetPair pair;
  int preset = 0;
};

/// Units in order: sequence, preset, pair. The pairs of a sequence are spread evenly over it.
std::vector<TablesUnit> tablesUnits(const TablesPlan& plan, const std::vector<Dataset>& datasets);

/// One pipeline of the comparison.
struct TablesRun {
  std::string method;
  ModelType model = ModelType::kEssential;
  double ratio = kPaperRatio;
};

/// cp_ransac at every ratio, every other method once, and at Table 4's preset the other models too.
std::vector<TablesRun> tablesRuns(const TablesPlan& plan, int preset);

}  // namespace gms_ransac
