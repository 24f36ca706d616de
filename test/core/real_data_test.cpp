// Every method on a few pairs of every set of real images: each ends with a pose or a status with the reason, and
// keeps no match that its own model rejects.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter.h"
#include "methods/method.h"
#include "shared_data.h"

namespace gms_ransac {
namespace {

namespace fs = std::filesystem;

constexpr int kPairs = 6;  ///< of each set, spread over it
constexpr int kFeatures = 1000;

std::vector<std::pair<std::string, ModelType>> methodsAndModels() {
  std::vector<std::pair<std::string, ModelType>> all;
  for (const MethodEntry& method : methods()) {
    for (ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
      all.emplace_back(method.name, model);
    }
  }
  return all;
}

/// Residual in pixels of one match under the estimated model, written independently of the core: Sampson. Points are
/// pixels of the ideal pinhole camera.
double sampsonError(const RobustResult& robust, const Camera& camera, cv::Point2f reference, cv::Point2f current) {
  Eigen::Vector3d p(reference.x, reference.y, 1), q(current.x, current.y, 1);
  double pixels = 1;
  if (robust.model_type == ModelType::kEssential) {
    const Eigen::Matrix3d to_ray = camera.K().inverse();
    p = to_ray * p;
    q = to_ray * q;
    pixels = camera.meanFocalLength();
  }
  const Eigen::Vector3d line_q = robust.model * p, line_p = robust.model.transpose() * q;
  return pixels * std::abs(q.dot(line_q)) / std::hypot(line_q.head<2>().norm(), line_p.head<2>().norm());
}

/// Transfer error of a match under the homography, pixels, root mean square of both directions.
double transferError(const RobustResult& robust, cv::Point2f reference, cv::Point2f current) {
  const Eigen::Vector3d p(reference.x, reference.y, 1), q(current.x, current.y, 1);
  const double forward = ((robust.model * p).hnormalized() - q.hnormalized()).norm();
  const double backward = ((robust.model.inverse() * q).hnormalized() - p.hnormalized()).norm();
  return std::sqrt((forward * forward + backward * backward) / 2);
}

void expectHonestOutcome(const MatchResult& result, bool calibrated) {
  const std::set<Status> without_pose = {Status::kTooFewKeypoints, Status::kTooFewMatches, Status::kGmsRejected,
                                         Status::kRansacFailed};
  if (!calibrated) {
    EXPECT_FALSE(result.robust.pose_found);
    EXPECT_TRUE(result.status == Status::kUncalibrated || without_pose.count(result.status)) << toString(result.status);
    return;
  }
  EXPECT_EQ(result.robust.pose_found, !without_pose.count(result.status)) << toString(result.status);
  if (!result.robust.pose_found) return;
  EXPECT_TRUE(result.status == Status::kOk || result.status == Status::kLowParallax) << toString(result.status);
  const Eigen::Matrix3d& R = result.robust.pose.R;
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-6);
  EXPECT_GT(R.determinant(), 0);
  if (result.status == Status::kOk) {
    EXPECT_NEAR(result.robust.pose.t.norm(), 1, 1e-6);
  }
}

/// Every inlier lies within the threshold of the model, except for methods in which the model gives only the pose.
void expectInliersWithinThreshold(const MatchFilter& filter, const Frame& reference, const Frame& current,
                                  const MatchResult& result) {
  const RobustOptions& options = filter.options().robust;
  const bool model_selects = !makeMethod(filter.options())->filterDecides();
  int inliers = 0;
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (result.stage[i] != MatchStage::kInlier) continue;
    ++inliers;
    if (!model_selects) continue;
    const cv::KeyPoint& a = reference.features.keypoints[static_cast<size_t>(result.matches[i].reference)];
    const cv::KeyPoint& b = current.features.keypoints[static_cast<size_t>(result.matches[i].current)];
    const cv::Point2f p = filter.camera().undistort(a.pt), q = filter.camera().undistort(b.pt);
    const double error = result.robust.model_type == ModelType::kHomography
                             ? transferError(result.robust, p, q)
                             : sampsonError(result.robust, filter.camera(), p, q);
    ASSERT_LT(error, options.inlierThreshold() * (1 + 1e-3)) << "match " << i;
  }
  EXPECT_EQ(inliers, result.inliers);
}

std::vector<DatasetPair> spread(const std::vector<DatasetPair>& all) {
  const size_t step = std::max<size_t>(1, all.size() / kPairs);
  std::vector<DatasetPair> some;
  for (size_t i = 0; i < all.size() && static_cast<int>(some.size()) < kPairs; i += step) some.push_back(all[i]);
  return some;
}

TEST(RealData, EveryMethodEndsWithAPoseOrAReasonOnEverySet) {
  const std::vector<std::string> paths = dataSets();
  if (paths.empty()) GTEST_SKIP() << "needs image sets in " << dataFolder();
  for (const std::string& path : paths) {
    const Dataset dataset = Dataset::open(path);
    const std::vector<DatasetPair> pairs = spread(dataset.pairs(1, 1));
    ASSERT_FALSE(pairs.empty()) << path;
    for (const DatasetPair& pair : pairs) {
      Frame reference, current;
      for (const auto& [method, model] : methodsAndModels()) {
        SCOPED_TRACE(dataset.name() + " " + dataset.frames()[static_cast<size_t>(pair.current)].name + " " + method +
                     " " + toString(model));
        MatchFilterOptions options;
        options.method = method;
        options.robust.model = model;
        options.extractor.features = kFeatures;
        MatchFilter filter(options);
        if (reference.features.keypoints.empty()) {
          filter.extract(dataset.image(pair.reference), reference);
          filter.extract(dataset.image(pair.current), current);
        }
        if (dataset.intrinsics()) filter.setCamera(Camera(*dataset.intrinsics(), reference.features.image_size));
        MatchResult result;
        filter.filter(reference, current, result);
        expectHonestOutcome(result, filter.camera().calibrated());
        expectInliersWithinThreshold(filter, reference, current, result);
      }
    }
  }
}

}  // namespace
}  // namespace gms_ransac
