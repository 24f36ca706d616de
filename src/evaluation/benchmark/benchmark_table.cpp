#include "benchmark/benchmark_table.h"

#include <cstdio>
#include <iterator>

#include "run/metrics.h"

namespace gms_ransac {

BenchmarkRow& BenchmarkTable::row(const std::string& stage, const std::string& name, const std::string& baseline) {
  auto place = rows_.end();
  for (auto row = rows_.begin(); row != rows_.end(); ++row) {
    if (row->stage != stage) continue;
    if (row->name == name) return *row;
    place = std::next(row);
  }
  return *rows_.insert(place, {stage, name, baseline});
}

void BenchmarkTable::print(std::ostream& out) {
  out << "| stage | what | ms | p95 | times faster | kept | correct |\n|---|---|---|---|---|---|---|\n";
  std::string stage;
  for (const BenchmarkRow& row : rows_) {
    char numbers[64], ratio[32] = "", kept[32] = "", correct[32] = "";
    std::snprintf(numbers, sizeof(numbers), "%.3f | %.3f", median(row.ms), percentile(row.ms, 95));
    if (!row.baseline.empty()) {
      std::snprintf(ratio, sizeof(ratio), "%.1f", median(this->row(row.stage, row.baseline).ms) / median(row.ms));
    }
    if (row.pairs > 0) std::snprintf(kept, sizeof(kept), "%.0f", row.kept / row.pairs);
    if (row.pairs_with_truth > 0) std::snprintf(correct, sizeof(correct), "%.0f", row.correct / row.pairs_with_truth);
    out << "| " << (stage == row.stage ? "" : row.stage) << " | " << row.name << " | " << numbers << " | " << ratio
        << " | " << kept << " | " << correct << " |\n";
    stage = row.stage;
  }
}

}  // namespace gms_ransac
