// Every method on a few pairs of every set of real images: each ends with a pose or a status with the reason.
#include <set>

#include <gtest/gtest.h>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"
#include "invariants.h"
#include "methods/method.h"
#include "shared_data.h"

namespace gms_ransac {
namespace {

constexpr int kPairs = 3;  ///< of each set, spread over it; digest_test has two more
constexpr int kFeatures = 1000;

/// A status that goes with what there is of calibration and pose.
void expectHonestStatus(const MatchResult& result, bool calibrated) {
  const std::set<Status> without_pose = {Status::kTooFewKeypoints, Status::kTooFewMatches, Status::kGmsRejected,
                                         Status::kRansacFailed};
  const bool failed = without_pose.count(result.status) > 0;
  EXPECT_EQ(result.robust.judgement.pose_found, calibrated && !failed) << toString(result.status);
  const bool posed =
      result.status == Status::kOk || result.status == Status::kLowParallax || result.status == Status::kMotionUnknown;
  EXPECT_TRUE(failed || (calibrated ? posed : result.status == Status::kUncalibrated)) << toString(result.status);
  if (result.status == Status::kOk) {
    EXPECT_NEAR(result.robust.judgement.pose.t.norm(), 1, 1e-6);
  }
}

TEST(RealData, EveryMethodEndsWithAPoseOrAReasonOnEverySet) {
  const std::vector<std::string> paths = dataSets();
  if (paths.empty()) GTEST_SKIP() << "needs image sets in " << dataFolder();
  for (const std::string& path : paths) {
    const Dataset dataset = Dataset::open(path);
    const int every = std::max<int>(1, static_cast<int>(dataset.pairs(1, 1).size()) / kPairs);
    std::vector<DatasetPair> pairs = dataset.pairs(1, every);
    ASSERT_FALSE(pairs.empty()) << path;
    pairs.resize(std::min<size_t>(pairs.size(), kPairs));
    for (const DatasetPair& pair : pairs) {
      MatchFilterOptions options;
      options.extractor.features = kFeatures;
      Frame reference, current;
      MatchFilter(options).extract(dataset.image(pair.reference), reference);
      MatchFilter(options).extract(dataset.image(pair.current), current);
      for (const MethodEntry& method : methods()) {
        for (const ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
          SCOPED_TRACE(dataset.name() + " " + dataset.frames()[static_cast<size_t>(pair.current)].name + " " +
                       method.name + " " + toString(model));
          options.method = method.name;
          options.robust.model = model;
          MatchFilter filter(options);
          if (dataset.intrinsics()) filter.setCamera(Camera(*dataset.intrinsics(), reference.features.image_size));
          MatchResult result;
          filter.filter(reference, current, result);
          EXPECT_EQ(brokenResult(reference.features, current.features, result), "");
          expectHonestStatus(result, filter.camera().calibrated());
        }
      }
    }
  }
}

}  // namespace
}  // namespace gms_ransac
