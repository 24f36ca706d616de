#include "tables/tables_plan.h"

#include <algorithm>

namespace gms_ransac {

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

}  // namespace gms_ransac
