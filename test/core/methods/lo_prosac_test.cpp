// The method `lo_prosac` on scenes whose truth is known, where it is to do more than others.
#include <cmath>

#include <gtest/gtest.h>

#include "two_view_scene.h"

namespace gms_ransac {
namespace {

/// The noise is that of ORB, growing with the octave.
TwoViewSceneOptions orbLike(uint64_t seed = 1) {
  TwoViewSceneOptions options;
  options.seed = seed;
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

struct MeanErrors {
  double rotation = 0, direction = 0;  ///< degrees
  int kept = 0;
};

MeanErrors meanErrors(const std::string& method, const RobustOptions& robust, double outliers) {
  constexpr int kScenes = 40;
  const auto estimator = makeEstimator(method, robust);
  MeanErrors mean;
  for (int k = 0; k < kScenes; ++k) {
    TwoViewSceneOptions options = orbLike(static_cast<uint64_t>(k));
    options.outlier_ratio = outliers;
    options.matches = 400;
    options.translation = 0.3 * Eigen::Vector3d(std::cos(k), 0.3 * std::sin(k), std::sin(k));
    const TwoViewScene scene = makeTwoViewScene(options);
    const RobustResult result = estimated(*estimator, scene);
    EXPECT_TRUE(result.judgement.translation_observable || method != "lo_prosac");
    mean.rotation += poseErrors(result, scene).rotation / kScenes;
    mean.direction += poseErrors(result, scene).direction / kScenes;
    mean.kept += correctKept(result, scene);
  }
  return mean;
}

TEST(LoProsac, IsAsGoodAsAnExhaustiveRansac) {
  RobustOptions exhaustive;
  exhaustive.max_iterations = 100000;
  exhaustive.success_probability = 0.999999999;
  for (const double outliers : {0.1, 0.3, 0.5, 0.7}) {
    SCOPED_TRACE(outliers);
    const MeanErrors ours = meanErrors("lo_prosac", {}, outliers), ransac = meanErrors("ransac", exhaustive, outliers);
    // Where no match is far the prior of the parallax costs up to two hundredths of a degree, a sixth of a pixel.
    EXPECT_LE(ours.rotation, ransac.rotation + 0.025);
    EXPECT_LE(ours.direction, ransac.direction + 0.2);
    EXPECT_LT(ours.rotation, 0.1);
    EXPECT_LT(ours.direction, 0.8);
    EXPECT_GE(ours.kept, 0.98 * ransac.kept);
  }
}

TEST(LoProsac, SurvivesNinetyPercentOutliers) {
  TwoViewSceneOptions options = orbLike();
  options.outlier_ratio = 0.9;
  options.matches = 1500;
  const TwoViewScene scene = makeTwoViewScene(options);
  RobustOptions robust;
  robust.max_iterations = 20000;
  const RobustResult result = estimated("lo_prosac", robust, scene);
  EXPECT_LE(result.effort.hypotheses, robust.max_iterations);
  EXPECT_LT(poseErrors(result, scene).rotation, 0.5);
  EXPECT_LT(poseErrors(result, scene).direction, 5);
}

TEST(LoProsac, KeepsNoMoreHypothesesThanAllowed) {
  RobustOptions robust;
  robust.max_iterations = 3;
  const RobustResult result = estimated("lo_prosac", robust, makeTwoViewScene(orbLike()));
  EXPECT_LE(result.effort.hypotheses, 3);
  EXPECT_TRUE(result.model_found);
}

TEST(LoProsac, TellsTheMotionsOfAPlaneApartByWhatLiesBehindTheCamera) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    TwoViewSceneOptions options = orbLike(seed);
    options.shape = SceneShape::kPlane;
    const double heading = static_cast<double>(seed);
    options.translation = {0.4 * std::cos(heading), 0.4 * std::sin(heading), 0.1};
    const TwoViewScene scene = makeTwoViewScene(options);
    const RobustResult result = estimated("lo_prosac", {}, scene);
    EXPECT_LT(poseErrors(result, scene).direction, 5) << seed;
    EXPECT_TRUE(result.judgement.translation_observable) << seed;
  }
}

/// The camera goes around a point ahead of it by an angle, radians, and keeps looking at it.
TwoViewSceneOptions orbit(double angle, double distance, TwoViewSceneOptions options) {
  options.rotation = {0, angle, 0};
  const Eigen::Vector3d centre(0, 0, distance);
  options.translation = centre - Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()) * centre;
  return options;
}

TEST(LoProsac, FindsAWideStepAroundSomethingFlat) {
  constexpr double kDistance = 4;
  for (const double degrees : {50., 60., 70.}) {
    for (uint64_t seed = 0; seed < 5; ++seed) {
      SCOPED_TRACE(degrees + static_cast<double>(seed) / 10);
      const double angle = degrees * M_PI / 180;
      TwoViewSceneOptions options = orbit(angle, kDistance, orbLike(seed));
      options.shape = SceneShape::kPlane;
      options.outlier_ratio = 0.3;
      options.plane_normal = {-std::sin(0.5 * angle), 0.1, std::cos(0.5 * angle)};
      options.plane_distance = kDistance * std::cos(0.5 * angle);
      const TwoViewScene scene = makeTwoViewScene(options);
      for (const char* method : {"lo_prosac", "gms_ransac"}) {
        const RobustResult result = estimated(method, {}, scene);
        // The other motion of the plane may explain the matches as well, but then the direction is not known.
        if (!result.judgement.translation_observable) continue;
        EXPECT_LT(poseErrors(result, scene).rotation, 3) << method;
        EXPECT_LT(poseErrors(result, scene).direction, 10) << method;
      }
    }
  }
}

TEST(LoProsac, FindsAWideStepAroundAnObject) {
  constexpr double kDistance = 4;
  for (uint64_t seed = 0; seed < 5; ++seed) {
    TwoViewSceneOptions options = orbit(M_PI / 3, kDistance, orbLike(seed));
    options.nearest = 0.8 * kDistance;
    options.farthest = 1.2 * kDistance;
    options.mostly_near = false;
    options.outlier_ratio = 0.3;
    const TwoViewScene scene = makeTwoViewScene(options);
    const RobustResult result = estimated("lo_prosac", {}, scene);
    EXPECT_TRUE(result.judgement.translation_observable) << seed;
    EXPECT_LT(poseErrors(result, scene).rotation, 1) << seed;
    EXPECT_LT(poseErrors(result, scene).direction, 2) << seed;
  }
}

TEST(LoProsac, FindsForwardMotion) {
  for (uint64_t seed = 0; seed < 5; ++seed) {
    TwoViewSceneOptions options = orbLike(seed);
    options.rotation = {0.001, 0.004, -0.001};
    options.translation = {0.01, 0.02, -0.6};
    options.farthest = 60;
    options.nearest = 3;
    const TwoViewScene scene = makeTwoViewScene(options);
    const RobustResult result = estimated("lo_prosac", {}, scene);
    EXPECT_LT(poseErrors(result, scene).rotation, 0.1) << seed;
    EXPECT_LT(poseErrors(result, scene).direction, 1) << seed;
  }
}

}  // namespace
}  // namespace gms_ransac
