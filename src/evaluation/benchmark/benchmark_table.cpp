#include "benchmark/benchmark_table.h"

#include <algorithm>
#include <cstdio>

#include "run/metrics.h"

namespace gms_ransac {

const BenchmarkRow* BenchmarkTable::find(const std::string& stage, const std::string& name) const {
  for (const BenchmarkRow& row : rows_) {
    if (row.stage == stage && row.name == name) return &row;
  }
  return nullptr;
}

BenchmarkRow& BenchmarkTable::row(const std::string& stage, const std::string& name, const std::string& baseline) {
  if (const BenchmarkRow* found = find(stage, name)) return const_cast<BenchmarkRow&>(*found);
  rows_.emplace_back();
  rows_.back().stage = stage;
  rows_.back().name = name;
  rows_.back().baseline = baseline;
  return rows_.back();
}

std::vector<const BenchmarkRow*> BenchmarkTable::byStage() const {
  std::vector<const BenchmarkRow*> ordered;
  for (const BenchmarkRow& first : rows_) {
    if (std::find_if(ordered.begin(), ordered.end(),
                     [&](const BenchmarkRow* row) { return row->stage == first.stage; }) != ordered.end()) {
      continue;
    }
    for (const BenchmarkRow& row : rows_) {
      if (row.stage == first.stage) ordered.push_back(&row);
    }
  }
  return ordered;
}

void BenchmarkTable::print(std::ostream& out) const {
  out << "| stage | what | ms | p95 | times faster | kept | correct |\n|---|---|---|---|---|---|---|\n";
  const std::string* stage = nullptr;
  for (const BenchmarkRow* row : byStage()) {
    const BenchmarkRow* baseline = row->baseline.empty() ? nullptr : find(row->stage, row->baseline);
    char numbers[64], ratio[32] = "", kept[32] = "", correct[32] = "";
    std::snprintf(numbers, sizeof(numbers), "%.3f | %.3f", median(row->ms), percentile(row->ms, 95));
    if (baseline) std::snprintf(ratio, sizeof(ratio), "%.1f", median(baseline->ms) / median(row->ms));
    if (row->pairs > 0) std::snprintf(kept, sizeof(kept), "%.0f", row->kept / row->pairs);
    const int with_truth = row->pairs_with_truth;
    if (with_truth > 0) std::snprintf(correct, sizeof(correct), "%.0f", row->correct / with_truth);
    out << "| " << (stage && *stage == row->stage ? "" : row->stage) << " | " << row->name << " | " << numbers << " | "
        << ratio << " | " << kept << " | " << correct << " |\n";
    stage = &row->stage;
  }
}

}  // namespace gms_ransac
