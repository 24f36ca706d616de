// The method `fast` on scenes whose truth is known: accuracy, honesty about degenerate motion, determinism, cost.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "gms_ransac/method.h"
#include "gms_ransac/robust_estimator.h"
#include "random.h"
#include "ransac/stratified_sampler.h"
#include "two_view/pose_model.h"
#include "two_view/residual.h"
#include "two_view_scene.h"

namespace {
long g_allocations = 0;
}

// Not inlined, or the compiler takes new and delete for a mismatched pair.
[[gnu::noinline]] void* operator new(size_t size) {
  ++g_allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace gms_ransac {
namespace {

constexpr double kFocal = 500;

Camera testCamera() {
  CameraIntrinsics intrinsics;
  intrinsics.fx = intrinsics.fy = kFocal;
  intrinsics.cx = 320;
  intrinsics.cy = 240;
  return Camera(intrinsics, cv::Size(640, 480));
}

/// Two views of a scene. X_current = R X_reference + t; noise is that of ORB, growing with the octave.
struct Scene {
  PointPairs pairs;
  std::vector<uint8_t> correct;
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
};

struct SceneOptions {
  int count = 800;
  double outliers = 0.3;
  double noise_px = 0.3;
  Eigen::Vector3d rotation = {0.01, -0.03, 0.02}, t = {0.2, 0.05, 0.1};
  double nearest = 2, farthest = 8;
  bool planar = false;
  uint64_t seed = 1;
};

Scene makeScene(const SceneOptions& options) {
  Scene scene;
  scene.R = rotationFromVector(options.rotation);
  scene.t = options.t;
  std::mt19937_64 generator(options.seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  PointPairs& pairs = scene.pairs;
  pairs.resize(options.count);
  pairs.image_reference = pairs.image_current = {640, 480};
  scene.correct.assign(static_cast<size_t>(options.count), 0);
  for (size_t i = 0; i < scene.correct.size();) {
    const double u = 640 * uniform(generator), v = 480 * uniform(generator);
    const double inverse_depth =
        1 / options.farthest + uniform(generator) * (1 / options.nearest - 1 / options.farthest);
    const Eigen::Vector3d ray((u - 320) / kFocal, (v - 240) / kFocal, 1);
    const double depth = options.planar ? 4 / (1 + 0.3 * ray.x() - 0.2 * ray.y()) : 1 / inverse_depth;
    const Eigen::Vector3d Y = scene.R * (depth * ray) + scene.t;
    double x = kFocal * Y.x() / Y.z() + 320, y = kFocal * Y.y() / Y.z() + 240;
    if (Y.z() < 0.1 || x < 0 || x > 640 || y < 0 || y > 480) continue;
    scene.correct[i] = uniform(generator) >= options.outliers;
    const int octave = static_cast<int>(8 * uniform(generator) * uniform(generator));
    const double sigma = options.noise_px * std::pow(1.2, 0.5 * octave);
    if (!scene.correct[i]) {
      x = 640 * uniform(generator);
      y = 480 * uniform(generator);
    }
    pairs.x_reference[i] = static_cast<float>(u + sigma * normal(generator));
    pairs.y_reference[i] = static_cast<float>(v + sigma * normal(generator));
    pairs.x_current[i] = static_cast<float>(x + sigma * normal(generator));
    pairs.y_current[i] = static_cast<float>(y + sigma * normal(generator));
    pairs.octave_reference[i] = pairs.octave_current[i] = static_cast<uint8_t>(octave);
    // A confidence that is right more often than not, as motion statistics are.
    pairs.score[i] = static_cast<int>(20 * uniform(generator)) + (scene.correct[i] ? 8 : 0);
    pairs.support[i] = static_cast<float>(pairs.score[i]) / 8.f;
    pairs.distance[i] =
        static_cast<uint16_t>(scene.correct[i] ? 20 + 20 * uniform(generator) : 35 + 30 * uniform(generator));
    pairs.second_distance[i] = 70;
    ++i;
  }
  return scene;
}

double degrees(double radians) { return radians * 180 / M_PI; }

double rotationError(const RobustResult& result, const Scene& scene) {
  return degrees(Eigen::AngleAxisd(result.pose.R * scene.R).angle());
}

double directionError(const RobustResult& result, const Scene& scene) {
  const Eigen::Vector3d truth = -(scene.R.transpose() * scene.t).normalized();
  return degrees(std::acos(std::min(1.0, std::max(-1.0, truth.dot(result.pose.t.normalized())))));
}

int correctKept(const RobustResult& result, const Scene& scene) {
  int kept = 0;
  for (size_t i = 0; i < scene.correct.size(); ++i) kept += result.inlier[i] && scene.correct[i];
  return kept;
}

std::unique_ptr<Method> makeFast(const RobustOptions& options = {}) { return makeEstimator("fast", options); }

std::unique_ptr<Method> makeFast(ModelType model) {
  RobustOptions options;
  options.model = model;
  return makeFast(options);
}

class OutlierShare : public testing::TestWithParam<double> {};

TEST_P(OutlierShare, IsAsGoodAsAnExhaustiveRansac) {
  RobustOptions exhaustive;
  exhaustive.max_iterations = 100000;
  exhaustive.confidence = 1 - 1e-9;
  const auto fast = makeFast(), ransac = makeEstimator("ransac", exhaustive);
  const Camera camera = testCamera();
  double fast_rotation = 0, fast_direction = 0, ransac_rotation = 0, ransac_direction = 0;
  int fast_kept = 0, ransac_kept = 0;
  constexpr int kScenes = 5;
  for (int k = 0; k < kScenes; ++k) {
    SceneOptions options;
    options.outliers = GetParam();
    options.count = 400;
    options.seed = static_cast<uint64_t>(k);
    options.t = 0.3 * Eigen::Vector3d(std::cos(k), 0.3 * std::sin(k), std::sin(k));
    const Scene scene = makeScene(options);
    RobustResult result;
    fast->reset();
    fast->estimate(scene.pairs, camera, result);
    ASSERT_TRUE(result.pose_found);
    EXPECT_TRUE(result.translation_observable);
    fast_rotation += rotationError(result, scene) / kScenes;
    fast_direction += directionError(result, scene) / kScenes;
    fast_kept += correctKept(result, scene);
    ransac->estimate(scene.pairs, camera, result);
    ransac_rotation += rotationError(result, scene) / kScenes;
    ransac_direction += directionError(result, scene) / kScenes;
    ransac_kept += correctKept(result, scene);
  }
  // Where no match is far the prior of the parallax costs a hundredth of a degree, a tenth of a pixel.
  EXPECT_LE(fast_rotation, ransac_rotation + 0.02);
  EXPECT_LE(fast_direction, ransac_direction + 0.1);
  EXPECT_LT(fast_rotation, 0.15);
  EXPECT_LT(fast_direction, 2);
  EXPECT_GE(fast_kept, 0.98 * ransac_kept);
}

INSTANTIATE_TEST_SUITE_P(From10To70Percent, OutlierShare, testing::Values(0.1, 0.3, 0.5, 0.7));

TEST(FastEstimator, SurvivesNinetyPercentOutliers) {
  SceneOptions options;
  options.outliers = 0.9;
  options.count = 1500;
  const Scene scene = makeScene(options);
  RobustOptions robust;
  robust.max_iterations = 20000;
  RobustResult result;
  makeFast(robust)->estimate(scene.pairs, testCamera(), result);
  ASSERT_TRUE(result.pose_found);
  EXPECT_LE(result.effort.hypotheses, robust.max_iterations);
  EXPECT_LT(rotationError(result, scene), 0.5);
  EXPECT_LT(directionError(result, scene), 5);
}

TEST(FastEstimator, KeepsNoMoreHypothesesThanAllowed) {
  const Scene scene = makeScene({});
  RobustOptions robust;
  robust.max_iterations = 3;
  RobustResult result;
  makeFast(robust)->estimate(scene.pairs, testCamera(), result);
  EXPECT_LE(result.effort.hypotheses, 3);
  EXPECT_TRUE(result.model_found);
}

TEST(FastEstimator, InliersAreTheSameOnEveryInstructionSet) {
  for (ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
    SceneOptions options;
    options.planar = model == ModelType::kHomography;
    const Scene scene = makeScene(options);
    RobustOptions robust;
    robust.model = model;
    robust.simd = SimdLevel::kScalar;
    RobustResult expected, result;
    makeFast(robust)->estimate(scene.pairs, testCamera(), expected);
    ASSERT_TRUE(expected.model_found);
    for (SimdLevel level : {SimdLevel::kNeon, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
      if (!simdLevelSupported(level)) continue;
      robust.simd = level;
      makeFast(robust)->estimate(scene.pairs, testCamera(), result);
      EXPECT_EQ(expected.inlier, result.inlier) << toString(level);
      EXPECT_EQ(expected.model, result.model) << toString(level);
      EXPECT_EQ(expected.pose.R, result.pose.R) << toString(level);
    }
  }
}

TEST(FastEstimator, RepeatsItselfAfterAReset) {
  const Scene first = makeScene({});
  SceneOptions options;
  options.seed = 2;
  const Scene second = makeScene(options);
  const auto estimator = makeFast();
  RobustResult a, b, fresh;
  estimator->estimate(first.pairs, testCamera(), a);
  estimator->estimate(second.pairs, testCamera(), b);
  estimator->reset();
  estimator->estimate(first.pairs, testCamera(), fresh);
  EXPECT_EQ(a.inlier, fresh.inlier);
  EXPECT_EQ(a.model, fresh.model);
  EXPECT_EQ(a.effort.hypotheses, fresh.effort.hypotheses);
  estimator->estimate(second.pairs, testCamera(), fresh);
  EXPECT_EQ(b.model, fresh.model);
}

TEST(FastEstimator, SaysThatAPureRotationShowsNoTranslation) {
  SceneOptions options;
  options.t.setZero();
  options.rotation = {0.05, -0.1, 0.03};
  const Scene scene = makeScene(options);
  RobustResult result;
  makeFast()->estimate(scene.pairs, testCamera(), result);
  ASSERT_TRUE(result.pose_found);
  EXPECT_FALSE(result.translation_observable);
  EXPECT_LT(result.median_parallax_px, 1);
  EXPECT_LT(rotationError(result, scene), 0.02);
  EXPECT_NEAR(1, result.pose.t.norm(), 1e-9);
  EXPECT_GT((result.pose.covariance.topLeftCorner<3, 3>().trace()), 0.5);
}

/// Two motions explain the views of a plane equally well; smallest distance of the result to one of them, in degrees.
double errorToPlaneMotions(const RobustResult& result, const Scene& scene) {
  const Eigen::Matrix3d H = scene.R + scene.t * Eigen::RowVector3d(0.3, -0.2, 1) / 4;  // n^T X = 4 in the reference
  cv::Mat H_cv;
  cv::eigen2cv(H, H_cv);
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(H_cv, cv::Mat::eye(3, 3, CV_64F), rotations, translations, normals);
  double best = 180;
  for (size_t i = 0; i < rotations.size(); ++i) {
    Scene motion;
    cv::cv2eigen(rotations[i], motion.R);
    cv::cv2eigen(translations[i], motion.t);
    best = std::min(best, std::max(rotationError(result, motion), directionError(result, motion) / 10));
  }
  return best;
}

TEST(FastEstimator, FindsAMotionOfThePlane) {
  for (ModelType model : {ModelType::kEssential, ModelType::kHomography}) {
    for (uint64_t seed = 0; seed < 5; ++seed) {
      SceneOptions options;
      options.planar = true;
      options.seed = seed;
      options.t = {0.4, 0.1, 0.3};
      const Scene scene = makeScene(options);
      RobustResult result;
      makeFast(model)->estimate(scene.pairs, testCamera(), result);
      ASSERT_TRUE(result.pose_found);
      EXPECT_LT(errorToPlaneMotions(result, scene), 0.5) << toString(model) << ", seed " << seed;
      EXPECT_GT(correctKept(result, scene), 480);
    }
  }
}

TEST(FastEstimator, TellsTheMotionsOfAPlaneApartByWhatLiesBehindTheCamera) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    SceneOptions options;
    options.planar = true;
    options.seed = seed;
    const double heading = static_cast<double>(seed);
    options.t = {0.4 * std::cos(heading), 0.4 * std::sin(heading), 0.1};
    const Scene scene = makeScene(options);
    RobustResult result;
    makeFast()->estimate(scene.pairs, testCamera(), result);
    ASSERT_TRUE(result.pose_found);
    EXPECT_LT(directionError(result, scene), 5) << "seed " << seed;
    EXPECT_TRUE(result.translation_observable) << "seed " << seed;
  }
}

TEST(FastEstimator, SaysWhenBothMotionsOfAPlaneSeeAllOfIt) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    SceneOptions options;
    options.planar = true;
    options.seed = seed;
    options.t = {-0.25, 0.1, 0.4};
    const Scene scene = makeScene(options);
    RobustResult result;
    makeFast()->estimate(scene.pairs, testCamera(), result);
    ASSERT_TRUE(result.pose_found);
    EXPECT_LT(errorToPlaneMotions(result, scene), 0.5) << "seed " << seed;
    EXPECT_TRUE(result.ambiguous) << "seed " << seed;
    EXPECT_FALSE(result.translation_observable) << "seed " << seed;
    EXPECT_GT(result.median_parallax_px, 10) << "seed " << seed;
  }
}

TEST(FastEstimator, FindsForwardMotion) {
  for (uint64_t seed = 0; seed < 5; ++seed) {
    SceneOptions options;
    options.rotation = {0.001, 0.004, -0.001};
    options.t = {0.01, 0.02, -0.6};
    options.seed = seed;
    options.farthest = 60;
    options.nearest = 3;
    const Scene scene = makeScene(options);
    RobustResult result;
    makeFast()->estimate(scene.pairs, testCamera(), result);
    ASSERT_TRUE(result.pose_found);
    EXPECT_LT(rotationError(result, scene), 0.1) << seed;
    EXPECT_LT(directionError(result, scene), 1) << seed;
  }
}

TEST(FastEstimator, FindsAFundamentalMatrixWithoutACamera) {
  const Scene scene = makeScene({});
  RobustResult result;
  makeFast()->estimate(scene.pairs, Camera(), result);
  ASSERT_TRUE(result.model_found);
  EXPECT_FALSE(result.pose_found);
  EXPECT_EQ(ModelType::kFundamental, result.model_type);
  EXPECT_LT(std::abs(result.model.determinant()), 1e-9);
  EXPECT_GT(correctKept(result, scene), 500);
  for (size_t i = 0; i < result.inlier.size(); ++i) {
    if (!result.inlier[i]) continue;
    const double squared = sampsonSquared(result.model, scene.pairs.x_reference[i], scene.pairs.y_reference[i],
                                          scene.pairs.x_current[i], scene.pairs.y_current[i]);
    EXPECT_LT(squared, 1);
  }
}

TEST(FastEstimator, FundamentalMatrixGivesThePoseOfACalibratedCamera) {
  const Scene scene = makeScene({});
  RobustResult result;
  makeFast(ModelType::kFundamental)->estimate(scene.pairs, testCamera(), result);
  ASSERT_TRUE(result.pose_found);
  EXPECT_LT(rotationError(result, scene), 0.5);
}

TEST(FastEstimator, RefusesWhatMeansNothing) {
  const auto estimator = makeFast();
  RobustResult result;
  PointPairs pairs;
  for (int count : {0, 1, 4, 5, 8, 100}) {
    pairs = PointPairs();
    pairs.resize(count);  // all points at the origin
    estimator->estimate(pairs, testCamera(), result);
    EXPECT_FALSE(result.model_found) << count;
    EXPECT_FALSE(result.pose_found);
    EXPECT_EQ(static_cast<size_t>(count), result.inlier.size());
  }
  SceneOptions noise;
  noise.outliers = 1;
  noise.count = 300;
  for (ModelType model : {ModelType::kEssential, ModelType::kFundamental, ModelType::kHomography}) {
    const Scene scene = makeScene(noise);
    makeFast(model)->estimate(scene.pairs, testCamera(), result);
    EXPECT_LT(result.inlier_count, 60);
  }
}

TEST(FastEstimator, AllocatesNothingOnceWarm) {
  SceneOptions fewer;
  fewer.count = 700;
  fewer.seed = 3;
  const Scene scene = makeScene({}), other = makeScene(fewer);
  const Camera camera = testCamera();
  const auto estimator = makeFast();
  RobustResult result;
  estimator->estimate(scene.pairs, camera, result);
  const long before = g_allocations;
  estimator->estimate(other.pairs, camera, result);
  estimator->estimate(scene.pairs, camera, result);
  EXPECT_EQ(before, g_allocations);
}

/// The mean of the normalised squared errors over many draws of the noise is their number of degrees of freedom.
TEST(FastEstimator, CovarianceIsThatOfTheErrors) {
  constexpr int kDraws = 150;
  const auto estimator = makeFast();
  double rotation = 0, both = 0;
  for (int k = 0; k < kDraws; ++k) {
    SceneOptions options;
    options.seed = static_cast<uint64_t>(100 + k);
    options.count = 400;
    options.outliers = 0.2;
    options.t = {0.3, -0.1, 0.4};
    const Scene scene = makeScene(options);
    RobustResult result;
    estimator->reset();
    estimator->estimate(scene.pairs, testCamera(), result);
    ASSERT_TRUE(result.pose_found);
    const Eigen::AngleAxisd difference(result.pose.R * scene.R);
    Eigen::Matrix<double, 6, 1> error;
    error.head<3>() = result.pose.t + (scene.R.transpose() * scene.t).normalized();
    error.tail<3>() = difference.angle() * difference.axis();
    const Eigen::Matrix3d rotation_covariance = result.pose.covariance.bottomRightCorner<3, 3>();
    rotation += error.tail<3>().dot(rotation_covariance.inverse() * error.tail<3>()) / kDraws;
    // Rank five: the direction along t is left out by projecting onto its tangent plane.
    Eigen::Vector3d basis[2];
    PoseModel::tangent(result.pose.t, basis);
    Eigen::Matrix<double, 5, 6> P = Eigen::Matrix<double, 5, 6>::Zero();
    P.block<1, 3>(0, 0) = basis[0].transpose();
    P.block<1, 3>(1, 0) = basis[1].transpose();
    P.bottomRightCorner<3, 3>().setIdentity();
    const Eigen::Matrix<double, 5, 5> covariance = P * result.pose.covariance * P.transpose();
    const Eigen::Matrix<double, 5, 1> projected = P * error;
    both += projected.dot(covariance.inverse() * projected) / kDraws;
  }
  EXPECT_GT(rotation, 3 * 0.5);
  EXPECT_LT(rotation, 3 * 1.6);
  EXPECT_GT(both, 5 * 0.5);
  EXPECT_LT(both, 5 * 1.6);
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
  sampler.setCells(order, cells);
  sampler.begin({kCount, 5, 0.99, 10000});
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
  sampler.setCells(order, cells);
  sampler.begin({400, 5, 0.99, 1000});
  Random random(1);
  int sample[5];
  sampler.draw(random, sample);
  EXPECT_LT(sampler.prefix(), 400);
  for (int place : sample) EXPECT_LT(place, sampler.prefix());
  for (int k = 0; k < 400; ++k) sampler.draw(random, sample);
  EXPECT_EQ(400, sampler.prefix());
}

}  // namespace
}  // namespace gms_ransac
