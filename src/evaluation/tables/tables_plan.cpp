#include "tables/tables_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace gms_ransac {

nlohmann::json planJson(const TablesPlan& plan) {
  const MatchFilterOptions& base = plan.base;
  const MotionStatisticsOptions& gms = base.motion_statistics;
  return {{"sequences", plan.sequences},
          {"gap", plan.gap},
          {"pairs", plan.pairs},
          {"repeats", plan.repeats},
          {"presets", plan.presets},
          {"ratios", plan.ratios},
          {"methods", plan.methods},
          {"model", toString(plan.model)},
          {"extractor", base.extractor.extractor},
          {"levels", base.extractor.levels},
          {"scale_factor", base.extractor.scale_factor},
          {"fast_threshold", base.extractor.fast_threshold},
          {"grid", {gms.grid_columns, gms.grid_rows}},
          {"alpha", gms.threshold_factor},
          {"rotation", gms.rotation},
          {"scale", gms.scale},
          {"threshold_px", base.robust.threshold_px},
          {"confidence", base.robust.confidence},
          {"max_iterations", base.robust.max_iterations},
          {"refine", base.robust.refine},
          {"quality", base.robust.quality},
          {"acceptance", static_cast<int>(gms.acceptance)},
          {"distance_reading", static_cast<int>(base.distance_reading)},
          {"one_to_one", base.one_to_one},
          {"lan_mutual", base.lan_mutual},
          {"second_alpha", base.second_alpha},
          {"threads", base.extractor.threads},
          {"seed", base.robust.seed}};
}

std::vector<TablesUnit> tablesUnits(const TablesPlan& plan, const std::vector<Dataset>& datasets) {
  std::vector<TablesUnit> units;
  for (size_t s = 0; s < datasets.size(); ++s) {
    const std::vector<DatasetPair> all = datasets[s].pairs(plan.gap, 1);
    const size_t count = std::min(all.size(), static_cast<size_t>(plan.pairs));
    for (const int preset : plan.presets) {
      for (size_t k = 0; k < count; ++k) {
        TablesUnit unit;
        unit.index = static_cast<int>(units.size());
        unit.sequence = static_cast<int>(s);
        unit.pair = all[k * all.size() / count];
        unit.preset = preset;
        units.push_back(unit);
      }
    }
  }
  return units;
}

std::vector<TablesRun> tablesRuns(const TablesPlan& plan, int preset) {
  std::vector<TablesRun> runs;
  for (const double ratio : plan.ratios) runs.push_back({"cp_ransac", plan.model, ratio});
  for (const std::string& method : plan.methods) runs.push_back({method, plan.model, kPaperRatio});
  if (preset != kTable4Preset) return runs;
  for (const ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
    if (model == plan.model) continue;
    runs.push_back({"cp_ransac", model, kPaperRatio});
    for (const std::string& method : plan.methods) runs.push_back({method, model, kPaperRatio});
  }
  return runs;
}

std::string ratioName(double ratio) {
  for (int denominator = 1; denominator <= 10; ++denominator) {
    const double numerator = ratio * denominator;
    if (std::abs(numerator - std::round(numerator)) > 1e-9) continue;
    return std::to_string(static_cast<int>(std::round(numerator))) + "/" + std::to_string(denominator);
  }
  char text[32];
  std::snprintf(text, sizeof(text), "%g", ratio);
  return text;
}

}  // namespace gms_ransac
