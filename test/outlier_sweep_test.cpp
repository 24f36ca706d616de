// The sweep over outlier ratios: what the paper's idea must show on true labels.
#include "tables/outlier_sweep.h"

#include <map>

#include <gtest/gtest.h>

namespace gms_ransac {
namespace {

TEST(OutlierSweep, ConfidenceOrderNeedsFewerHypothesesAtEqualSuccess) {
  OutlierSweepOptions options;
  options.methods = {"gms_ransac", "cp_ransac", "prosac"};
  options.repeat = 10;
  int calls = 0;
  const std::vector<OutlierSweepRow> rows = sweepOutliers(options, [&] { ++calls; });
  EXPECT_EQ(calls, sweepLength(options));
  ASSERT_EQ(rows.size(), 27u);
  std::map<double, std::map<std::string, OutlierSweepRow>> table;
  for (const OutlierSweepRow& row : rows) table[row.outlier_ratio][row.method] = row;
  for (const auto& [ratio, row] : table) {
    if (ratio < 0.15 || ratio > 0.55) continue;  // below there is nothing to gain, above uniform draws meet their cap
    SCOPED_TRACE(ratio);
    for (const char* method : {"cp_ransac", "prosac"}) {
      EXPECT_GE(row.at(method).successes, 9);
      EXPECT_LT(row.at(method).hypotheses, row.at("gms_ransac").hypotheses);
    }
    EXPECT_GE(row.at("gms_ransac").successes, 9);
  }
  for (const OutlierSweepRow& row : rows) {
    EXPECT_EQ(row.trials, 10);
    EXPECT_GE(row.precision, 0);
    EXPECT_LE(row.recall, 1);
  }
}

TEST(OutlierSweep, LoProsacIsAsGoodAsAnExhaustiveSearchOnTheRenderedScene) {
  OutlierSweepOptions options;
  options.methods = {"ransac", "lo_prosac"};
  options.robust.max_iterations = 100000;
  options.robust.success_probability = 0.9999;
  options.repeat = 4;
  std::map<double, std::map<std::string, OutlierSweepRow>> table;
  for (const OutlierSweepRow& row : sweepOutliers(options, [] {})) table[row.outlier_ratio][row.method] = row;
  for (const auto& [ratio, row] : table) {
    if (ratio > 0.75) continue;  // 10 to 70 percent
    SCOPED_TRACE(ratio);
    EXPECT_GE(row.at("lo_prosac").successes, row.at("ransac").successes);
    EXPECT_GE(row.at("lo_prosac").precision, row.at("ransac").precision - 0.01);
    EXPECT_GE(row.at("lo_prosac").recall, row.at("ransac").recall - 0.01);
    EXPECT_LT(row.at("lo_prosac").hypotheses, row.at("ransac").hypotheses);
  }
}

TEST(OutlierSweep, RefusesAnUnknownMethod) {
  OutlierSweepOptions options;
  options.methods = {"nonsense"};
  EXPECT_THROW(sweepOutliers(options, [] {}), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
