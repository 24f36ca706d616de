// Each step of the judgement by itself, against numbers that a formula or a simulation gives.
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "judgement/candidates.h"
#include "judgement/match_noise.h"
#include "judgement/pose_covariance.h"
#include "judgement/refined_pose.h"
#include "judgement/segmentation.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

const ResidualKernels& kernels() { return residualKernels(detectSimdLevel()); }

/// A scene whose points are judged at the optimum near its true motion.
struct JudgedScene {
  TwoViewScene scene;
  TwoViewPoints points;
  RefinedPose refined{kernels()};

  explicit JudgedScene(const TwoViewSceneOptions& options) : JudgedScene(makeTwoViewScene(options)) {}
  explicit JudgedScene(TwoViewScene drawn) : scene(std::move(drawn)) {
    points.set(scene.pairs, scene.camera, ModelType::kEssential, RobustOptions().inlierThreshold(), 0);
    refined.points = &points;
    TwoViewPose& pose = refined.pose;
    // Without a translation any direction is as good; the optimum is found from one.
    pose = {scene.R, scene.t.norm() > 0 ? Eigen::Vector3d(scene.t.normalized()) : Eigen::Vector3d::UnitX()};
    const PoseModel model(kernels(), points.view());
    model.refine(kRobustLoss, 50, pose, kEnough);
    refined.noise.measure(model, pose);
    refined.plausible.copy(points.view(), [](int) { return true; });
    refined.information.sum(kernels(), points.view(), pose, refined.noise.loss(), points.cells());
    refined.covariance = poseCovariance(refined.information, refined.noise.variance(), 0);
  }
  /// The table of the pose, whose direction is known to `direction_sigma` radians.
  Verdict compared(const std::vector<AlternativeMotion>& motions = {}, double direction_sigma = 0.001) const {
    RotationAlone alone;
    std::vector<float> storage;
    fitRotation(refined, alone);
    Verdict verdict = compareRotations(refined, alone, true);
    compareMotions(refined, direction_sigma, motions, storage, verdict);
    return verdict;
  }
};

TwoViewSceneOptions exactScene(uint64_t seed) {
  TwoViewSceneOptions options;
  options.seed = seed;
  options.outlier_ratio = 0;
  return options;
}

TEST(MatchNoiseStep, FindsTheSigmaThatWasDrawn) {
  for (const float sigma : {0.1f, 0.3f, 1.f}) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal(0, sigma);
    std::uniform_real_distribution<float> uniform(-MatchNoise::kWindow, MatchNoise::kWindow);
    std::vector<float> squares;
    for (int i = 0; i < 4000; ++i) {
      const float residual = i % 5 == 0 ? uniform(random) : normal(random);
      squares.push_back(residual * residual);
    }
    MatchNoise noise(kernels());
    noise.measure(squares, 4000);
    EXPECT_NEAR(noise.sigma(), sigma, 0.05 * sigma);
  }
}

TEST(MatchNoiseStep, OfASceneIsThatOfItsKeypoints) {
  for (const double sigma : {0.2, 0.5}) {
    TwoViewSceneOptions options = exactScene(1);
    options.noise_px = sigma;
    EXPECT_NEAR(JudgedScene(options).refined.noise.sigma(), sigma, 0.05 * sigma);
  }
}

/// The residual of a match in thresholds, signed.
double signedResidual(const TwoViewPose& pose, const PointColumnsView& points, int i) {
  const Eigen::Matrix3d E = pose.essential();
  const Eigen::Vector3d p(points.x1[i], points.y1[i], 1), q(points.x2[i], points.y2[i], 1);
  const double norm = (E * p).head<2>().squaredNorm() + (E.transpose() * q).head<2>().squaredNorm();
  return q.dot(E * p) * std::sqrt(static_cast<double>(points.weight[i]) / norm);
}

TEST(PoseDerivatives, AreThoseOfSmallSteps) {
  const JudgedScene judged(exactScene(2));
  const PointColumnsView points = judged.points.view();
  AlignedColumns columns;
  columns.resize(DerivativeColumn::kCount, points.count);
  PoseModel(kernels(), points).differentiate(judged.refined.pose, kRobustLoss, columns.column(0));
  Eigen::Vector3d basis[2];
  PoseModel::tangent(judged.refined.pose.t, basis);
  constexpr double kStep = 1e-4;
  for (int i = 0; i < points.count; i += 50) {
    for (int k = 0; k < DerivativeColumn::kPoseCount; ++k) {
      TwoViewPose moved = judged.refined.pose;
      if (k < 3) {
        moved.R = rotationFromVector(kStep * Eigen::Vector3d::Unit(k)) * moved.R;
      } else {
        moved.t = (moved.t + kStep * basis[k - 3]).normalized();
      }
      const double change = (signedResidual(moved, points, i) - signedResidual(judged.refined.pose, points, i)) / kStep;
      EXPECT_NEAR(columns.column(k)[i], change, 0.01 * std::abs(change) + 0.2) << i << " " << k;
    }
  }
}

TEST(PoseInformationStep, PartsAddUpToTheWhole) {
  const JudgedScene judged(exactScene(1));
  const PoseInformation& all = judged.refined.information;
  for (const auto* parts : {&all.cells, &all.blocks}) {
    int count = 0;
    ParameterVector gradient = ParameterVector::Zero();
    PoseSquare products = PoseSquare::Zero();
    for (const PartSums& part : *parts) {
      count += part.count;
      gradient += part.gradient();
      products += part.ownProducts();
    }
    EXPECT_EQ(count, all.used);
    EXPECT_LT((gradient - all.gradient).norm(), 1e-4 * all.scatter.diagonal().cwiseSqrt().norm());
    EXPECT_LT((all.bend * products - all.ofPose()).norm(), 1e-4 * all.ofPose().norm());
  }
}

TEST(PoseCovarianceStep, IsTheSpreadOfTheEstimates) {
  // Scenes that differ by the noise of their points alone would need a seed of its own for it; with 1000 points each
  // the geometry is nearly the same.
  constexpr int kScenes = 200;
  double squares = 0, variances = 0, directions = 0, direction_variances = 0;
  double nees_rotation = 0, nees_direction = 0;
  std::vector<double> widened;
  for (uint64_t seed = 1; seed <= kScenes; ++seed) {
    const JudgedScene judged(exactScene(seed));
    const PoseCovariance& spread = judged.refined.covariance;
    const Eigen::Vector3d rotation = rotationVector(judged.refined.pose.R * judged.scene.R.transpose());
    const double direction = (judged.refined.pose.t - judged.scene.t.normalized()).squaredNorm();
    squares += rotation.squaredNorm();
    variances += spread.of_matches.topLeftCorner<3, 3>().trace();
    directions += direction;
    direction_variances += spread.of_matches.bottomRightCorner<2, 2>().trace();
    nees_rotation += rotation.squaredNorm() / spread.covariance.topLeftCorner<3, 3>().trace();
    nees_direction += direction / spread.covariance.bottomRightCorner<2, 2>().trace();
    widened.push_back(spread.covariance.trace() / spread.of_matches.trace());
  }
  // The sum of 200 squares is known to a tenth.
  EXPECT_NEAR(squares / variances, 1, 0.3);
  EXPECT_NEAR(directions / direction_variances, 1, 0.3);
  // The published covariance differs in a few scenes, whose noise contradicts the camera by chance and widens it.
  EXPECT_NEAR(nees_rotation / kScenes, 0.85, 0.25);
  EXPECT_NEAR(nees_direction / kScenes, 0.85, 0.25);
  std::sort(widened.begin(), widened.end());
  EXPECT_NEAR(widened[3 * kScenes / 4], 1, 0.01);
}

TEST(PoseCovarianceStep, GrowsWithTheSquareOfTheNoise) {
  const auto variance = [](double sigma) {
    double sum = 0;
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      TwoViewSceneOptions options = exactScene(seed);
      options.noise_px = sigma;
      sum += JudgedScene(options).refined.covariance.of_matches.trace();
    }
    return sum;
  };
  EXPECT_NEAR(variance(0.4) / variance(0.2), 4, 0.6);
}

TEST(PoseCovarianceStep, WhereNothingMovesTheRotationIsKnownAndTheDirectionIsNot) {
  PoseInformation all;
  all.used = 100;
  all.curvature.setZero();
  all.curvature.topLeftCorner<3, 3>() = 1e4 * Eigen::Matrix3d::Identity();
  all.scatter = 1e4 * ParameterSquare::Identity();
  all.gradient.setZero();
  all.line_rotations.setZero();
  const PoseSquare covariance = poseCovariance(all, 1, 0).covariance;
  EXPECT_DOUBLE_EQ(covariance(0, 0), 1e-4);
  EXPECT_DOUBLE_EQ(covariance(3, 3), 1);
}

TEST(PoseCovarianceStep, DirectionSigmaIsThatOfTheWidestAxis) {
  PoseSquare covariance = PoseSquare::Identity();
  covariance.bottomRightCorner<2, 2>() << 5, 3, 3, 5;  // eigenvalues 8 and 2
  EXPECT_DOUBLE_EQ(directionSigma(covariance), std::sqrt(8));
}

TEST(CameraTestStep, FindsTheFocalLengthThatIsWrong) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    TwoViewSceneOptions options = exactScene(seed);
    options.focal_error = 0.03;
    const CameraTest camera = JudgedScene(options).refined.covariance.camera;
    EXPECT_GT(camera.statistic, 1) << seed;
  }
}

TEST(CameraTestStep, TestsAScoreByItsScatter) {
  PoseInformation all;
  all.curvature = 1e4 * ParameterSquare::Identity();
  all.scatter = 1e4 * ParameterSquare::Identity();
  all.gradient.setZero();
  all.gradient[DerivativeColumn::kFocalLength] = 400;  // four deviations
  const PoseSquare inverse = 1e-4 * PoseSquare::Identity();
  const CameraTest camera = testCamera(all, inverse);
  EXPECT_EQ(camera.parameter, CameraParameter::kFocalLength);
  EXPECT_NEAR(camera.statistic, 16 / 6.63, 1e-3);
  // An error of 0.03 by the prior and 0.04 by the score, with a variance of 1e-4: the posterior has a mean of 0.036 and
  // a variance of 9e-5. No other group errs, so theirs has the prior's and no more than the weight of other causes.
  EXPECT_NEAR(camera.second_moment(0, 0), 0.036 * 0.036 + 9e-5, 1e-4);
  EXPECT_LT(camera.second_moment(1, 1), 0.01 * 0.01);
  // Rounding may leave a scatter indefinite. Models with that parameter then tell nothing; the others do as before.
  all.scatter(kParameters - 1, kParameters - 1) = -1;
  const CameraTest without = testCamera(all, inverse);
  EXPECT_NEAR(without.second_moment(0, 0), 0.9 * (0.036 * 0.036 + 9e-5), 1e-4);
  EXPECT_EQ(without.second_moment(kCameraParameters - 1, kCameraParameters - 1), 0);
}

TEST(CameraTestStep, IsSeldomContradictedByChance) {
  int contradicted = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    const CameraTest camera = JudgedScene(exactScene(seed)).refined.covariance.camera;
    contradicted += camera.statistic > 1;
    if (camera.statistic < 0.3) {
      EXPECT_LT(camera.second_moment(0, 0), 0.015 * 0.015) << seed;
    }
  }
  EXPECT_LE(contradicted, 10);  // each of four groups in one of a hundred
}

TEST(Vuong, IsTheSumOverTheRootOfTheSquaresOfCells) {
  const std::vector<int32_t> cells = {0, 0, 1, 2, 3};
  const auto statistic = [&](const std::vector<double>& differences) {
    return vuongStatistic(5, cells, [&](size_t i) { return differences[i]; });
  };
  EXPECT_DOUBLE_EQ(statistic({0.5, 0.5, 1, 1, 1}), 2);  // four cells of one
  EXPECT_DOUBLE_EQ(statistic({1, 1, -2, 3, -3}), 0);    // a tie
  EXPECT_DOUBLE_EQ(statistic({0, 0, 0, 0, 0}), 0);
  EXPECT_DOUBLE_EQ(statistic({3, 0, 4, 0, 0}), 7. / 5);
}

TEST(CandidatesStep, ARotationWinsWhereTheCameraOnlyRotates) {
  TwoViewSceneOptions options = exactScene(1);
  options.translation.setZero();
  const Verdict verdict = JudgedScene(options).compared();
  EXPECT_LT(verdict.rotation, 0);
  EXPECT_GT(verdict.static_share, 0.9);
  EXPECT_TRUE(verdict.rotationIsBetter());
  EXPECT_TRUE(verdict.onlyRotated());
}

TEST(CandidatesStep, ARotationLosesWhereTheCameraMoves) {
  const Verdict verdict = JudgedScene(exactScene(1)).compared();
  EXPECT_GT(verdict.rotation, 10);
  EXPECT_GT(verdict.rolling, 5);
  EXPECT_LT(verdict.static_share, 0.1);
  EXPECT_LT(verdict.share_at_infinity, 0.1);
}

TEST(CandidatesStep, RollingShutterIsNoTranslation) {
  TwoViewSceneOptions options = exactScene(1);
  options.translation.setZero();
  options.rotation = {0.03, -0.06, 0.03};
  options.readout = 0.9;
  EXPECT_LT(JudgedScene(options).compared().rolling, 0);
}

TEST(CandidatesStep, WithAGlobalShutterOnlyARotationAloneIsCompared) {
  const JudgedScene judged(exactScene(1));
  RotationAlone alone;
  fitRotation(judged.refined, alone);
  const Verdict verdict = compareRotations(judged.refined, alone, false);
  EXPECT_EQ(verdict.rolling, verdict.rotation);
}

TEST(Explanations, TogetherAreTheirMeanAndSpread) {
  const auto about_x = [](double angle) { return rotationFromVector({angle, 0, 0}); };
  const Eigen::Matrix3d own = 1e-4 * Eigen::Matrix3d::Identity();
  const Explanation both = togetherOf({{about_x(0.1), own, 0}, {about_x(0.3), own, 0}});
  EXPECT_NEAR((rotationVector(both.R) - Eigen::Vector3d(0.2, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(both.covariance(0, 0), 1e-4 + 0.1 * 0.1, 1e-9);
  EXPECT_NEAR(both.covariance(1, 1), 1e-4, 1e-9);
  // One that the matches contradict hardly counts; one that they prefer decides.
  EXPECT_NEAR(rotationVector(togetherOf({{about_x(0.1), own, 0}, {about_x(0.3), own, 15}}).R).x(), 0.1, 1e-3);
  EXPECT_NEAR(rotationVector(togetherOf({{about_x(0.1), own, 0}, {about_x(0.3), own, -15}}).R).x(), 0.3, 1e-3);
}

TEST(Explanations, ANarrowViewOfAPlaneLeavesTheRotationOpenAndAWideOneDoesNot) {
  // A camera that moves sideways past a plane, which looks like a rotation.
  const auto deviation = [](double image_share) {
    TwoViewSceneOptions options = exactScene(1);
    options.shape = SceneShape::kPlane;
    options.plane_normal = {0, 0, 1};
    options.image_share = image_share;
    options.translation = {0.8, 0, 0};
    options.rotation.setZero();
    const JudgedScene judged(options);
    RotationAlone alone;
    fitRotation(judged.refined, alone);
    const Verdict verdict = compareRotations(judged.refined, alone, true);
    const Explanation known = rotationWithoutTranslation(judged.refined, alone, verdict);
    return std::sqrt(known.covariance.trace());
  };
  EXPECT_GT(deviation(0.12), 2 * M_PI / 180);
  EXPECT_LT(deviation(1), 2 * M_PI / 180);
}

TEST(CandidatesStep, StaticShareIsThatOfTheBackground) {
  TwoViewSceneOptions options = exactScene(1);
  options.background = 0.4;
  EXPECT_NEAR(JudgedScene(options).compared().static_share, 0.4, 0.1);
}

TEST(CandidatesStep, NeitherTheMotionItselfNorWhatExplainsNothingStands) {
  const JudgedScene judged(exactScene(1));
  const Verdict same = judged.compared({{judged.refined.pose}}, 0.01);
  EXPECT_GE(same.other_motion, 1);
  EXPECT_TRUE(same.spread.isZero());
  const TwoViewPose other = {judged.refined.pose.R, judged.refined.pose.t.cross(Eigen::Vector3d::UnitY()).normalized()};
  EXPECT_GE(judged.compared({{other}}).other_motion, 1);
}

TEST(CandidatesStep, WithoutParallaxTwoDirectionsTie) {
  TwoViewSceneOptions options = exactScene(1);
  options.translation.setZero();
  const JudgedScene judged(options);
  Eigen::Vector3d basis[2];
  PoseModel::tangent(judged.refined.pose.t, basis);
  int ties = 0;
  for (const Eigen::Vector3d& t : {basis[0], basis[1], Eigen::Vector3d(-basis[0]), Eigen::Vector3d(-basis[1])}) {
    ties += judged.compared({{{judged.refined.pose.R, t}, true}}).other_motion;
  }
  EXPECT_GE(ties, 1);
}

/// A scene in which the matches of the upper left 8 x 12 cells follow another motion.
TwoViewScene brokenScene(uint64_t seed, double step) {
  TwoViewScene scene = makeTwoViewScene(exactScene(seed));
  for (size_t i = 0; i < scene.body.size(); ++i) {
    if (scene.pairs.x_reference[i] < 0.4f * 640 && scene.pairs.y_reference[i] < 0.6f * 480) {
      scene.pairs.x_current[i] += static_cast<float>(step);
      scene.pairs.y_current[i] += static_cast<float>(step);
    }
  }
  return scene;
}

TEST(SegmentationStep, FindsABreakWhereItIs) {
  const JudgedScene judged(brokenScene(1, 0.8));
  const PoseBreak found = findBreak(judged.refined.information, judged.refined.noise.variance());
  EXPECT_GT(found.statistic, 27);
  EXPECT_TRUE(found.holds(blockOf(0)));                // the upper left corner is on one side,
  EXPECT_FALSE(found.holds(blockOf(kCellCount - 1)));  // the lower right one on the other
  EXPECT_TRUE(found.holds(blockOf(3 * kCellSide + 3)));
  EXPECT_FALSE(found.holds(blockOf((kCellSide - 3) * kCellSide + kCellSide - 3)));
}

TEST(SegmentationStep, ARigidWorldSeldomBreaks) {
  int breaks = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    const JudgedScene judged(exactScene(seed));
    breaks += findBreak(judged.refined.information, judged.refined.noise.variance()).statistic > 27;
  }
  EXPECT_LE(breaks, 3);
}

}  // namespace
}  // namespace gms_ransac
