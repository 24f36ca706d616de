// The sweep over outlier ratios: what the paper's idea must show on true labels.
#include "run/outlier_sweep.h"

#include <map>

#include <gtest/gtest.h>

#include "run/metrics.h"

namespace gms_ransac {
namespace {

/// The trials of one method at one ratio.
struct Trials {
  int successes = 0;
  std::vector<double> hypotheses, precision, recall;
};
using Table = std::map<double, std::map<std::string, Trials>>;

Table sweep(const OutlierSweepOptions& options) {
  Table table;
  int records = 0;
  sweepOutliers(options, [&](const nlohmann::json& record) {
    Trials& trials = table[record["outlier_ratio"]][record["method"]];
    trials.successes += record["success"].get<bool>();
    trials.hypotheses.push_back(record["hypotheses"]);
    trials.precision.push_back(record["precision"]);
    trials.recall.push_back(record["recall"]);
    ++records;
  });
  EXPECT_EQ(records, sweepLength(options));
  return table;
}

TEST(OutlierSweep, ConfidenceOrderNeedsFewerHypothesesAtEqualSuccess) {
  OutlierSweepOptions options;
  options.methods = {"gms_ransac", "cp_ransac", "prosac"};
  options.repeat = 10;
  const Table table = sweep(options);
  ASSERT_EQ(table.size(), 9u);
  for (const auto& [ratio, row] : table) {
    if (ratio < 0.15 || ratio > 0.55) continue;  // below there is nothing to gain, above uniform draws meet their cap
    SCOPED_TRACE(ratio);
    for (const char* method : {"cp_ransac", "prosac"}) {
      EXPECT_GE(row.at(method).successes, 9);
      EXPECT_LT(median(row.at(method).hypotheses), median(row.at("gms_ransac").hypotheses));
    }
    EXPECT_GE(row.at("gms_ransac").successes, 9);
  }
}

TEST(OutlierSweep, LoProsacIsAsGoodAsAnExhaustiveSearchOnTheRenderedScene) {
  OutlierSweepOptions options;
  options.methods = {"ransac", "lo_prosac"};
  options.robust.max_iterations = 100000;
  options.robust.success_probability = 0.9999;
  options.repeat = 4;
  for (const auto& [ratio, row] : sweep(options)) {
    if (ratio > 0.75) continue;  // 10 to 70 percent
    SCOPED_TRACE(ratio);
    const Trials &ours = row.at("lo_prosac"), &exhaustive = row.at("ransac");
    EXPECT_GE(ours.successes, exhaustive.successes);
    EXPECT_GE(median(ours.precision), median(exhaustive.precision) - 0.01);
    EXPECT_GE(median(ours.recall), median(exhaustive.recall) - 0.01);
    EXPECT_LT(median(ours.hypotheses), median(exhaustive.hypotheses));
  }
}

}  // namespace
}  // namespace gms_ransac
