// The benchmark on a rendered pair: the same work on both sides, plausible counts, ratios that are ratios.
#include "benchmark/benchmark_suite.h"

#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "scenes/scene_writer.h"
#include "scratch_folder.h"

namespace gms_ransac {
namespace {

class BenchmarkTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const ScratchFolder folder;
    writeTumFolder(Scene(SceneOptions()), 2, folder.path(), [] {});
    const Dataset dataset = Dataset::open(folder.path());
    BenchmarkOptions options;
    options.features = 800;
    options.repeat = 2;
    options.methods = {"cp_ransac"};
    table_ = runBenchmark(dataset, dataset.pairs(1, 1), options, [] { ++pairs_done_; });
  }

  static const BenchmarkRow* find(const std::string& stage, const std::string& name) {
    for (const BenchmarkRow& row : table_.rows()) {
      if (row.stage == stage && row.name == name) return &row;
    }
    ADD_FAILURE() << "no row " << stage << ", " << name;
    return nullptr;
  }

  static inline BenchmarkTable table_;
  static inline int pairs_done_ = 0;
};

TEST_F(BenchmarkTest, MeasuresEveryRowOnEveryRepetition) {
  EXPECT_EQ(1, pairs_done_);
  std::set<std::string> stages;
  for (const BenchmarkRow& row : table_.rows()) {
    EXPECT_EQ(2U, row.ms.size()) << row.stage << ", " << row.name;
    EXPECT_EQ(1, row.pairs) << row.stage << ", " << row.name;
    EXPECT_GE(row.kept, row.correct);
    stages.insert(row.stage);
  }
  EXPECT_EQ(stages, std::set<std::string>({"GMS", "GMS, rotation + scale", "estimate", "extract", "match",
                                           "match + GMS + estimate", "whole frame"}));
}

TEST_F(BenchmarkTest, BothSidesDoTheSameWork) {
  const BenchmarkRow* baseline = find("match", "cv::BFMatcher");
  const BenchmarkRow* scalar = find("match", "scalar");
  const BenchmarkRow* dense = find("GMS", "dense GMS");
  const BenchmarkRow* sparse = find("GMS", "sparse");
  ASSERT_TRUE(baseline && scalar && dense && sparse);
  EXPECT_EQ(baseline->kept, scalar->kept);
  EXPECT_EQ(baseline->correct, scalar->correct);
  EXPECT_GT(dense->kept, 100);
  EXPECT_EQ(dense->kept, sparse->kept);
  EXPECT_EQ(dense->correct, sparse->correct);
}

TEST_F(BenchmarkTest, CorrectMatchesAreMostOfThoseKept) {
  for (const char* name : {"cp_ransac", "cp_ransac on extractor simd_orb", "OpenCV with cv::findEssentialMat RANSAC"}) {
    const BenchmarkRow* row = find("whole frame", name);
    ASSERT_TRUE(row);
    EXPECT_GT(row->correct, 0.9 * row->kept) << name;
  }
}

TEST(BenchmarkTable, PrintsMediansAndTheRatioToTheBaseline) {
  BenchmarkTable table;
  table.row("s", "baseline").ms = {4, 6, 20};
  BenchmarkRow& ours = table.row("s", "ours", "baseline");
  ours.ms = {2, 2, 3};
  ours.count(10);
  ours.count(20);
  ours.countCorrect(9);
  std::ostringstream text;
  table.print(text);
  EXPECT_NE(std::string::npos, text.str().find("| s | baseline | 6.000 | 18.600 |  |  |  |\n"));
  EXPECT_NE(std::string::npos, text.str().find("|  | ours | 2.000 | 2.900 | 3.0 | 15 | 9 |\n"));
}

}  // namespace
}  // namespace gms_ransac
