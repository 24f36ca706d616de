// A rotation from another sensor as a proposal: it helps if right, and costs nothing if wrong.
#include <algorithm>

#include <gtest/gtest.h>

#include "invariants.h"
#include "ransac/proposals.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr double kPriorSigma = 0.1 * kDegree;

/// The scene's rotation with `error` added about the reference camera's axes.
RotationPrior priorOf(const TwoViewScene& scene, const Eigen::Vector3d& error = Eigen::Vector3d::Zero()) {
  RotationPrior prior;
  prior.R = rotationFromVector(error) * scene.R.transpose();
  prior.covariance = kPriorSigma * kPriorSigma * Eigen::Matrix3d::Identity();
  return prior;
}

TwoViewScene turningScene(uint64_t seed, double outliers) {
  TwoViewSceneOptions options;
  options.seed = seed;
  options.outlier_ratio = outliers;
  options.rotation = {0.05, -0.12, 0.06};
  return makeTwoViewScene(options);
}

RobustResult withPrior(const std::string& method, const RobustOptions& options, TwoViewScene scene,
                       const RotationPrior& prior) {
  scene.pairs.rotation_prior = prior;
  return estimated(method, options, scene);
}

/// Sum of the squared Sampson distances of all matches, pixels squared, each at most 1.
double costOf(const RobustResult& result, const TwoViewScene& scene) {
  double cost = 0;
  for (size_t i = 0; i < scene.correct.size(); ++i) {
    cost +=
        std::min(1.0, squaredResidual(scene.camera, result, {scene.pairs.x_reference[i], scene.pairs.y_reference[i]},
                                      {scene.pairs.x_current[i], scene.pairs.y_current[i]}));
  }
  return cost;
}

TwoViewPose proposalFor(const TwoViewScene& scene, const RotationPrior& prior) {
  TwoViewPoints points;
  points.set(scene.pairs, scene.camera, ModelType::kEssential, 1, 0);
  int64_t evaluations = 0;
  points.countInto(&evaluations);
  PointColumns storage;
  const TwoViewPose pose = proposeFromRotation(residualKernels(detectSimdLevel()), points.view(), prior, storage);
  EXPECT_EQ(evaluations > 0, scene.pairs.size() > 0);
  return pose;
}

TEST(RotationProposal, FindsTheMotionAndTakesThePriorsNoiseOut) {
  TwoViewSceneOptions options;
  options.noise_px = 0;
  const TwoViewScene exact = makeTwoViewScene(options), noisy = turningScene(3, 0.5);
  const TwoViewPose of_exact = proposalFor(exact, priorOf(exact));
  EXPECT_LT(rotationError(of_exact.R, exact.R), 0.02);
  EXPECT_LT(directionError(of_exact.t, exact.t), 0.3);
  const TwoViewPose pose = proposalFor(noisy, priorOf(noisy, {2 * kPriorSigma, -2 * kPriorSigma, kPriorSigma}));
  EXPECT_LT(rotationError(pose.R, noisy.R), 0.1);
  EXPECT_LT(directionError(pose.t, noisy.t), 2);
}

TEST(RotationProposal, OfNothingIsFinite) {
  for (const int matches : {0, 1, 2, 5}) {
    TwoViewScene scene = turningScene(1, 0);
    scene.pairs.resize(matches);
    const TwoViewPose pose = proposalFor(scene, priorOf(scene));
    EXPECT_TRUE(pose.R.allFinite() && pose.t.allFinite()) << matches;
  }
}

class EveryMethodWithAPrior : public testing::TestWithParam<std::string> {};

TEST_P(EveryMethodWithAPrior, FindsWithAPriorWhatTooFewSamplesDoNot) {
  RobustOptions options;
  options.max_iterations = 3;
  int with = 0, without = 0;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    const TwoViewScene scene = turningScene(seed, 0.6);
    const auto right = [&](const RobustResult& result) {
      return result.judgement.pose_found && poseErrors(result, scene).rotation < 0.3 &&
             poseErrors(result, scene).direction < 5;
    };
    without += right(estimated(GetParam(), options, scene));
    with += right(withPrior(GetParam(), options, scene, priorOf(scene, {kPriorSigma, kPriorSigma, -kPriorSigma})));
  }
  EXPECT_GE(with, without);
  // T(d,d) tests one random match first, and so rejects four of ten right proposals.
  EXPECT_GE(with, GetParam() == "rransac_tdd" ? 1 : 7);
}

TEST_P(EveryMethodWithAPrior, IsNotWorseForAPriorThatIsWrong) {
  RobustOptions options;
  // Compare the result of the search, before any refinement: judged or not, it may be no better afterwards.
  options.refine = options.judge = false;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    const TwoViewScene scene = turningScene(seed, 0.4);
    const RobustResult alone = estimated(GetParam(), options, scene);
    const Eigen::Vector3d turn(0.05, -0.12, 0.06);
    RotationPrior shuffled = priorOf(scene), delayed = shuffled, mirrored = shuffled;
    shuffled.R = rotationFromVector({turn.z(), turn.x(), -turn.y()});
    delayed.R = Eigen::Matrix3d::Identity();
    mirrored.R = rotationFromVector(turn);
    for (const RotationPrior& wrong : {shuffled, delayed, mirrored}) {
      const RobustResult result = withPrior(GetParam(), options, scene, wrong);
      EXPECT_EQ(result.effort.hypotheses, alone.effort.hypotheses) << "the samples do not depend on it";
      ASSERT_EQ(result.model_found, alone.model_found);
      if (!alone.model_found) continue;
      const bool same = result.model == alone.model;
      EXPECT_TRUE(same || result.inlier_count >= alone.inlier_count || costOf(result, scene) <= costOf(alone, scene));
      if (GetParam() != "lo_prosac") continue;
      EXPECT_LT(poseErrors(result, scene).rotation, 0.1);
    }
  }
}

TEST_P(EveryMethodWithAPrior, TakesNoPriorForAnotherModel) {
  for (const ModelType model : {ModelType::kFundamental, ModelType::kHomography}) {
    RobustOptions options;
    options.model = model;
    const TwoViewScene scene = turningScene(2, 0.3);
    const RobustResult alone = estimated(GetParam(), options, scene);
    const RobustResult with = withPrior(GetParam(), options, scene, priorOf(scene));
    EXPECT_EQ(with.model, alone.model);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethodWithAPrior, testing::ValuesIn(methodNames()));

TEST(RotationPrior, LeavesATurnOnTheSpotATurnOnTheSpot) {
  TwoViewSceneOptions options;
  options.translation = {0, 0, 1e-9};
  options.rotation = {0.05, -0.12, 0.06};
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    options.seed = seed;
    const TwoViewScene scene = makeTwoViewScene(options);
    const RobustResult result = withPrior("lo_prosac", {}, scene, priorOf(scene, {kPriorSigma, 0, 0}));
    ASSERT_TRUE(result.judgement.pose_found);
    EXPECT_FALSE(result.judgement.translation_observable);
    EXPECT_LT(poseErrors(result, scene).rotation, 0.05);
  }
}

}  // namespace
}  // namespace gms_ransac
