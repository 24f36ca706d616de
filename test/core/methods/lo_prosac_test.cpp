// The method `lo_prosac` on scenes whose truth is known: accuracy, honesty about degenerate motion, determinism, cost.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_options.h"
#include "gms_ransac/robust_result.h"
#include "methods/method.h"
#include "random.h"
#include "ransac/stratified_sampler.h"
#include "two_view/pose_model.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

/// The noise is that of ORB, growing with the octave.
TwoViewSceneOptions orbLike() {
  TwoViewSceneOptions options;
  options.matches = 800;
  options.rotation = {0.01, -0.03, 0.02};
  options.translation = {0.2, 0.05, 0.1};
  options.nearest = 2;
  options.farthest = 8;
  options.mostly_near = true;
  options.plane_distance = 4;
  options.octaves = true;
  return options;
}

std::unique_ptr<Method> makeLoProsac(const RobustOptions& options = {}) { return makeEstimator("lo_prosac", options); }

std::unique_ptr<Method> makeLoProsac(ModelType model) {
  RobustOptions options;
  options.model = model;
  return makeLoProsac(options);
}

class OutlierShare : public testing::TestWithParam<double> {};

TEST_P(OutlierShare, IsAsGoodAsAnExhaustiveRansac) {
  RobustOptions exhaustive;
  exhaustive.max_iterations = 100000;
  exhaustive.success_probability = 0.999999999;
  const auto lo_prosac = makeLoProsac(), ransac = makeEstimator("ransac", exhaustive);
  const Camera camera = sceneCamera();
  double lo_prosac_rotation = 0, lo_prosac_direction = 0, ransac_rotation = 0, ransac_direction = 0;
  int lo_prosac_kept = 0, ransac_kept = 0;
  constexpr int kScenes = 40;
  for (int k = 0; k < kScenes; ++k) {
    TwoViewSceneOptions options = orbLike();
    options.outlier_ratio = GetParam();
    options.matches = 400;
    options.seed = static_cast<uint64_t>(k);
    options.translation = 0.3 * Eigen::Vector3d(std::cos(k), 0.3 * std::sin(k), std::sin(k));
    const TwoViewScene scene = makeTwoViewScene(options);
    RobustResult result;
    lo_prosac->reset();
    lo_prosac->estimate(scene.pairs, camera, result);
    ASSERT_TRUE(result.pose_found);
    EXPECT_TRUE(result.translation_observable);
    lo_prosac_rotation += poseErrors(result, scene).rotation / kScenes;
    lo_prosac_direction += poseErrors(result, scene).direction / kScenes;
    lo_prosac_kept += correctKept(result, scene);
    ransac->estimate(scene.pairs, camera, result);
    ransac_rotation += poseErrors(result, scene).rotation / kScenes;
    ransac_direction += poseErrors(result, scene).direction / kScenes;
    ransac_kept += correctKept(result, scene);
  }
  // Where no match is far the prior of the parallax costs up to two hundredths of a degree, a sixth of a pixel.
  EXPECT_LE(lo_prosac_rotation, ransac_rotation + 0.025);
  EXPECT_LE(lo_prosac_direction, ransac_direction + 0.2);
  EXPECT_LT(lo_prosac_rotation, 0.1);
  EXPECT_LT(lo_prosac_direction, 0.8);
  EXPECT_GE(lo_prosac_kept, 0.98 * ransac_kept);
}

INSTANTIATE_TEST_SUITE_P(From10To70Percent, OutlierShare, testing::Values(0.1, 0.3, 0.5, 0.7));

TEST(LoProsac, SurvivesNinetyPercentOutliers) {
  TwoViewSceneOptions options = orbLike();
  options.outlier_ratio = 0.9;
  options.matches = 1500;
  const TwoViewScene scene = makeTwoViewScene(options);
  RobustOptions robust;
  robust.max_iterations = 20000;
  RobustResult result;
  makeLoProsac(robust)->estimate(scene.pairs, sceneCamera(), result);
  ASSERT_TRUE(result.pose_found);
  EXPECT_LE(result.effort.hypotheses, robust.max_iterations);
  EXPECT_LT(poseErrors(result, scene).rotation, 0.5);
  EXPECT_LT(poseErrors(result, scene).direction, 5);
}

TEST(LoProsac, KeepsNoMoreHypothesesThanAllowed) {
  const TwoViewScene scene = makeTwoViewScene(orbLike());
  RobustOptions robust;
  robust.max_iterations = 3;
  RobustResult result;
  makeLoProsac(robust)->estimate(scene.pairs, sceneCamera(), result);
  EXPECT_LE(result.effort.hypotheses, 3);
  EXPECT_TRUE(result.model_found);
}

TEST(LoProsac, SaysThatAPureRotationShowsNoTranslation) {
  TwoViewSceneOptions options = orbLike();
  options.translation.setZero();
  options.rotation = {0.05, -0.1, 0.03};
  const TwoViewScene scene = makeTwoViewScene(options);
  RobustResult result;
  makeLoProsac()->estimate(scene.pairs, sceneCamera(), result);
  ASSERT_TRUE(result.pose_found);
  EXPECT_FALSE(result.translation_observable);
  EXPECT_LT(result.median_parallax_px, 1);
  EXPECT_LT(poseErrors(result, scene).rotation, 0.02);
  EXPECT_NEAR(1, result.pose.t.norm(), 1e-9);
  EXPECT_GT((result.pose.covariance.topLeftCorner<3, 3>().trace()), 0.5);
}

TEST(LoProsac, FindsAMotionOfThePlane) {
  for (ModelType model : {ModelType::kEssential, ModelType::kHomography}) {
    for (uint64_t seed = 0; seed < 5; ++seed) {
      TwoViewSceneOptions options = orbLike();
      options.shape = SceneShape::kPlane;
      options.seed = seed;
      options.translation = {0.4, 0.1, 0.3};
      const TwoViewScene scene = makeTwoViewScene(options);
      RobustResult result;
      makeLoProsac(model)->estimate(scene.pairs, sceneCamera(), result);
      ASSERT_TRUE(result.pose_found);
      EXPECT_LT(planePoseErrors(result, scene).rotation, 0.5) << toString(model) << ", seed " << seed;
      EXPECT_LT(planePoseErrors(result, scene).direction, 5) << toString(model) << ", seed " << seed;
      EXPECT_GT(correctKept(result, scene), 480);
    }
  }
}

TEST(LoProsac, TellsTheMotionsOfAPlaneApartByWhatLiesBehindTheCamera) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    TwoViewSceneOptions options = orbLike();
    options.shape = SceneShape::kPlane;
    options.seed = seed;
    const double heading = static_cast<double>(seed);
    options.translation = {0.4 * std::cos(heading), 0.4 * std::sin(heading), 0.1};
    const TwoViewScene scene = makeTwoViewScene(options);
    RobustResult result;
    makeLoProsac()->estimate(scene.pairs, sceneCamera(), result);
    ASSERT_TRUE(result.pose_found);
    EXPECT_LT(poseErrors(result, scene).direction, 5) << "seed " << seed;
    EXPECT_TRUE(result.translation_observable) << "seed " << seed;
  }
}

TEST(LoProsac, SaysWhenBothMotionsOfAPlaneSeeAllOfIt) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    TwoViewSceneOptions options = orbLike();
    options.shape = SceneShape::kPlane;
    options.seed = seed;
    options.translation = {-0.25, 0.1, 0.4};
    const TwoViewScene scene = makeTwoViewScene(options);
    RobustResult result;
    makeLoProsac()->estimate(scene.pairs, sceneCamera(), result);
    ASSERT_TRUE(result.pose_found);
    EXPECT_LT(planePoseErrors(result, scene).rotation, 0.5) << "seed " << seed;
    EXPECT_LT(planePoseErrors(result, scene).direction, 5) << "seed " << seed;
    EXPECT_TRUE(result.doubt == DirectionDoubt::kOtherMotion) << "seed " << seed;
    EXPECT_FALSE(result.translation_observable) << "seed " << seed;
    EXPECT_GT(result.median_parallax_px, 10) << "seed " << seed;
  }
}

TEST(LoProsac, FindsForwardMotion) {
  for (uint64_t seed = 0; seed < 5; ++seed) {
    TwoViewSceneOptions options = orbLike();
    options.rotation = {0.001, 0.004, -0.001};
    options.translation = {0.01, 0.02, -0.6};
    options.seed = seed;
    options.farthest = 60;
    options.nearest = 3;
    const TwoViewScene scene = makeTwoViewScene(options);
    RobustResult result;
    makeLoProsac()->estimate(scene.pairs, sceneCamera(), result);
    ASSERT_TRUE(result.pose_found);
    EXPECT_LT(poseErrors(result, scene).rotation, 0.1) << seed;
    EXPECT_LT(poseErrors(result, scene).direction, 1) << seed;
  }
}

TEST(LoProsac, RefusesWhatMeansNothing) {
  const auto estimator = makeLoProsac();
  RobustResult result;
  PointPairs pairs;
  for (int count : {0, 1, 4, 5, 8, 100}) {
    pairs = PointPairs();
    pairs.resize(count);  // all points at the origin
    estimator->estimate(pairs, sceneCamera(), result);
    EXPECT_FALSE(result.model_found) << count;
    EXPECT_FALSE(result.pose_found);
    EXPECT_EQ(static_cast<size_t>(count), result.inlier.size());
  }
  TwoViewSceneOptions noise = orbLike();
  noise.outlier_ratio = 1;
  noise.matches = 300;
  for (ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
    const TwoViewScene scene = makeTwoViewScene(noise);
    makeLoProsac(model)->estimate(scene.pairs, sceneCamera(), result);
    EXPECT_LT(result.inlier_count, 60);
  }
}

/// Mean of the squared error over the covariance, over the degrees of freedom (NEES): 1 where the covariance is true.
struct MeanNees {
  double rotation = 0, pose = 0;
};

MeanNees meanNees(double noise_px, int draws) {
  const auto estimator = makeLoProsac();
  MeanNees nees;
  for (int k = 0; k < draws; ++k) {
    TwoViewSceneOptions options = orbLike();
    options.seed = static_cast<uint64_t>(100 + k);
    options.matches = 400;
    options.noise_px = noise_px;
    options.outlier_ratio = 0.2;
    options.translation = {0.3, -0.1, 0.4};
    const TwoViewScene scene = makeTwoViewScene(options);
    RobustResult result;
    estimator->reset();
    estimator->estimate(scene.pairs, sceneCamera(), result);
    EXPECT_TRUE(result.translation_observable) << "seed " << k;
    const Eigen::AngleAxisd difference(result.pose.R * scene.R);
    Eigen::Matrix<double, 6, 1> error;
    error.head<3>() = result.pose.t + (scene.R.transpose() * scene.t).normalized();
    error.tail<3>() = difference.angle() * difference.axis();
    const Eigen::Matrix3d rotation_covariance = result.pose.covariance.bottomRightCorner<3, 3>();
    nees.rotation += error.tail<3>().dot(rotation_covariance.inverse() * error.tail<3>()) / 3 / draws;
    // Rank five: projecting onto the tangent plane of t removes the direction along it.
    Eigen::Vector3d basis[2];
    PoseModel::tangent(result.pose.t, basis);
    Eigen::Matrix<double, 5, 6> P = Eigen::Matrix<double, 5, 6>::Zero();
    P.block<1, 3>(0, 0) = basis[0].transpose();
    P.block<1, 3>(1, 0) = basis[1].transpose();
    P.bottomRightCorner<3, 3>().setIdentity();
    const Eigen::Matrix<double, 5, 5> covariance = P * result.pose.covariance * P.transpose();
    const Eigen::Matrix<double, 5, 1> projected = P * error;
    nees.pose += projected.dot(covariance.inverse() * projected) / 5 / draws;
  }
  return nees;
}

TEST(LoProsac, CovarianceIsThatOfTheErrors) {
  // At 1 px of noise on level 0 the coarser half of the keypoints lies beyond the threshold, which is 1 px there, too.
  for (const double noise_px : {0.2, 0.3, 0.5, 1.0}) {
    SCOPED_TRACE(noise_px);
    const MeanNees nees = meanNees(noise_px, 300);
    EXPECT_GT(nees.rotation, 0.7);
    EXPECT_LT(nees.rotation, 1.3);
    EXPECT_GT(nees.pose, 0.7);
    EXPECT_LT(nees.pose, 1.4);
  }
}

TEST(StratifiedSampler, SpreadsSamplesAtLeastAsWideAsUniformDraws) {
  // Confidence is highest in one corner, as motion statistics are highest in the densest texture.
  constexpr int kCount = 1000;
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<int> order(kCount);
  std::vector<int32_t> cells(kCount);
  for (int i = 0; i < kCount; ++i) {
    order[i] = i;
    const double reach = i < kCount / 2 ? 0.5 : 1;
    cells[i] =
        static_cast<int>(20 * reach * uniform(generator)) * 20 + static_cast<int>(20 * reach * uniform(generator));
  }
  const auto spread = [&cells](const int* sample) {
    double sum = 0;
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < i; ++j) {
        sum += std::hypot(cells[sample[i]] % 20 - cells[sample[j]] % 20, cells[sample[i]] / 20 - cells[sample[j]] / 20);
      }
    }
    return sum / 10;
  };
  StratifiedSampler sampler;
  sampler.begin({kCount, 5, 0.99, 10000}, order, cells);
  Random random(1);
  double stratified = 0, uniform_draws = 0;
  constexpr int kDraws = 2000;
  int sample[5];
  for (int k = 0; k < kDraws; ++k) {
    sampler.draw(random, sample);
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < i; ++j) ASSERT_NE(sample[i], sample[j]);
    }
    if (k >= 400) stratified += spread(sample) / (kDraws - 400);  // all matches take part by then
    drawDistinct(random, kCount, 5, sample);
    uniform_draws += spread(sample) / kDraws;
  }
  EXPECT_GE(stratified, uniform_draws);
}

TEST(StratifiedSampler, BeginsWithTheMostConfident) {
  std::vector<int> order(400);
  std::vector<int32_t> cells(400);
  for (int i = 0; i < 400; ++i) {
    order[i] = 399 - i;
    cells[i] = i;
  }
  StratifiedSampler sampler;
  sampler.begin({400, 5, 0.99, 1000}, order, cells);
  Random random(1);
  int sample[5];
  sampler.draw(random, sample);
  EXPECT_LT(sampler.prefix(), 400);
  for (int rank : sample) EXPECT_LT(rank, sampler.prefix());
  for (int k = 0; k < 400; ++k) sampler.draw(random, sample);
  EXPECT_EQ(400, sampler.prefix());
}

TEST(StratifiedSampler, BeginsWithTheShareThatIsAskedFor) {
  std::vector<int> order(400);
  std::vector<int32_t> cells(400);
  for (int i = 0; i < 400; ++i) order[i] = cells[i] = i;
  StratifiedSampler sampler;
  sampler.begin({400, 5, 0.99, 64}, order, cells, 0.5);
  Random random(1);
  int sample[5];
  sampler.draw(random, sample);
  EXPECT_EQ(200, sampler.prefix());
  int drawn = 1;
  while (sampler.draw(random, sample)) ++drawn;
  EXPECT_EQ(64, drawn);
}

}  // namespace
}  // namespace gms_ransac
