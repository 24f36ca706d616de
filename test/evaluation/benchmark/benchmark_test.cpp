// The benchmark on a rendered pair: the same work on both sides, plausible counts.
#include "benchmark/benchmark_suite.h"

#include <map>
#include <set>
#include <string>
#include <utility>

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
    const std::vector<DatasetPair> pairs = dataset.pairs(1, 1);
    benchmarkSeries(dataset, pairs, options).measure(0, pairs.size(), [](const Records& records) {
      ++pairs_done_;
      for (const nlohmann::json& record : records) rows_[{record["stage"], record["what"]}].push_back(record);
      return true;
    });
  }

  /// The first measurement.
  static nlohmann::json find(const std::string& stage, const std::string& what) { return rows_.at({stage, what})[0]; }

  static inline std::map<std::pair<std::string, std::string>, nlohmann::json> rows_;
  static inline int pairs_done_ = 0;
};

TEST_F(BenchmarkTest, MeasuresEveryRowOnEveryRepetition) {
  EXPECT_EQ(1, pairs_done_);
  std::set<std::string> stages;
  for (const auto& [name, row] : rows_) {
    SCOPED_TRACE(name.first + ", " + name.second);
    EXPECT_EQ(2U, row.size());
    EXPECT_GT(row[0]["ms"], 0);
    EXPECT_EQ(row[0]["correct"].is_null(), name.first == "extract");
    if (name.first != "extract") {
      EXPECT_GE(row[0]["kept"], row[0]["correct"]);
    }
    const nlohmann::json& baseline = row[0]["baseline"];
    EXPECT_TRUE(baseline.is_null() || rows_.count({name.first, baseline}) == 1);
    stages.insert(name.first);
  }
  EXPECT_EQ(stages, std::set<std::string>({"GMS", "GMS, rotation + scale", "estimate", "extract", "match",
                                           "match + GMS + estimate", "whole frame"}));
}

TEST_F(BenchmarkTest, BothSidesDoTheSameWork) {
  const nlohmann::json baseline = find("match", "cv::BFMatcher"), scalar = find("match", "scalar"),
                       dense = find("GMS", "dense GMS"), sparse = find("GMS", "sparse");
  for (const char* count : {"kept", "correct"}) {
    EXPECT_EQ(baseline[count], scalar[count]);
    EXPECT_EQ(dense[count], sparse[count]);
  }
  EXPECT_GT(dense["kept"], 100);
}

TEST_F(BenchmarkTest, CorrectMatchesAreMostOfThoseKept) {
  for (const char* name : {"cp_ransac", "cp_ransac on extractor simd_orb", "OpenCV with cv::findEssentialMat RANSAC"}) {
    const nlohmann::json row = find("whole frame", name);
    EXPECT_GT(row["correct"].get<double>(), 0.9 * row["kept"].get<double>()) << name;
  }
}

}  // namespace
}  // namespace gms_ransac
