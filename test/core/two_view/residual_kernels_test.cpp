// The SIMD kernels of estimation: against a double loop, and bit for bit against each other.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "simd_levels.h"
#include "two_view/kernels/point_columns.h"
#include "two_view/kernels/residual_kernels.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_model.h"
#include "two_view/two_view_points.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

/// Matches in normalised coordinates with a motion that explains two thirds of them, and some homography.
struct Problem {
  PointColumns columns;
  TwoViewPose pose;
  Eigen::Matrix3d H;

  Problem(int count, uint64_t seed) {
    TwoViewSceneOptions options;
    options.seed = seed;
    options.matches = count;
    options.outlier_ratio = 1 / 3.;
    options.octaves = true;
    const TwoViewScene scene = makeTwoViewScene(options);
    pose = {scene.R, scene.t.normalized()};
    H = pose.R + 0.1 * pose.t * Eigen::RowVector3d(0.1, -0.2, 1);
    TwoViewPoints points;
    points.set(scene.pairs, scene.camera, ModelType::kEssential, 1, 0.5);
    columns.copy(points.view(), [](int) { return true; });
  }
};

/// The bytes of everything that a table of kernels computes.
std::string allResults(const ResidualKernels& kernels, const Problem& problem) {
  const PointColumnsView points = problem.columns.view();
  const PoseParameters pose = problem.pose.parameters();
  const FloatMatrix homography(problem.H), inverse(problem.H.inverse());
  const auto &H = homography.entry, &G = inverse.entry;
  float D[8][9];
  std::mt19937 generator(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (auto& row : D) {
    for (float& entry : row) entry = uniform(generator);
  }
  std::string results;
  const auto add = [&results](const auto& values) {
    results.append(reinterpret_cast<const char*>(&values), sizeof(values));
  };
  const auto addFloats = [&](const float* first) {
    results.append(reinterpret_cast<const char*>(first), static_cast<size_t>(points.count) * sizeof(float));
  };
  const ParallaxPrior prior = {0.03f, 0.05f};
  for (float bound : {1e9f, 0.3f * static_cast<float>(points.count)}) {
    HypothesisScore score;
    kernels.scoreEpipolar(points, pose.E, bound, score);
    add(score);
    kernels.scorePose(points, pose, prior, bound, score);
    add(score);
    kernels.scoreHomography(points, H, G, bound, score);
    add(score);
  }
  for (const Loss& loss : {Loss{1, 0}, Loss{4, 1}}) {
    NormalEquations<5> five;
    kernels.linearizePose(points, pose, reinterpret_cast<const float(&)[2][3]>(D), loss, prior, five);
    add(five);
    NormalEquations<7> seven;
    kernels.linearizeFundamental(points, pose.E, reinterpret_cast<const float(&)[7][9]>(D), loss, seven);
    add(seven);
    NormalEquations<8> eight;
    kernels.linearizeHomography(points, H, D, loss, eight);
    add(eight);
    NormalEquations<3> three;
    kernels.linearizeRotation(points, pose.R, loss, three);
    add(three);
    add(kernels.poseCost(points, pose, loss, prior));
    add(kernels.poseCost(points, pose, loss, {}));
    add(kernels.epipolarCost(points, pose.E, loss));
    add(kernels.transferCost(points, H, loss));
    AlignedColumns columns;
    columns.resize(DerivativeColumn::kCount, std::max(1, points.size));
    add(kernels.differentiatePose(points, pose, reinterpret_cast<const float(&)[2][3]>(D), loss, columns.column(0)));
    for (int k = 0; k < DerivativeColumn::kCount; ++k) addFloats(columns.column(k));
    double products[DerivativeColumn::kParameterCount * (DerivativeColumn::kParameterCount + 1) / 2];
    kernels.sumProducts(columns.column(0), points.size, products);
    add(products);
  }
  std::vector<float> e(static_cast<size_t>(points.size));
  kernels.epipolarResiduals(points, pose.E, e.data());
  addFloats(e.data());
  kernels.poseResiduals(points, pose, e.data());
  addFloats(e.data());
  kernels.transferResiduals(points, H, e.data());
  addFloats(e.data());
  for (const auto function : {kernels.exponential, kernels.logarithm, kernels.errorFunction}) {
    std::vector<float> values(e.size());
    function(e.data(), 0.1f, points.size, values.data());
    addFloats(values.data());
  }
  return results;
}

TEST(ResidualKernels, EveryLevelReturnsTheSameBits) {
  for (int count : {0, 1, 7, 16, 33, 64, 65, 1003}) {
    const Problem problem(count, static_cast<uint64_t>(count));
    const std::string expected = allResults(residualKernels(SimdLevel::kScalar), problem);
    for (SimdLevel level : supportedLevels()) {
      EXPECT_TRUE(allResults(residualKernels(level), problem) == expected)
          << toString(level) << ", " << count << " matches";
    }
  }
}

TEST(ResidualKernels, FunctionsAreThoseOfTheLibrary) {
  const ResidualKernels& kernels = residualKernels(SimdLevel::kScalar);
  std::vector<float> x, result(16 * kLanes);
  for (int i = 0; i < 16 * kLanes; ++i) x.push_back(std::exp2(0.5f * static_cast<float>(i) - 64));
  const auto values = [&](const auto& function, float factor) {
    function(x.data(), factor, 16 * kLanes, result.data());
    return result;
  };
  const std::vector<float> rising = values(kernels.exponential, 1), falling = values(kernels.exponential, -1);
  const std::vector<float> logarithms = values(kernels.logarithm, 3), errors = values(kernels.errorFunction, 2);
  for (size_t i = 0; i < x.size(); ++i) {
    const double exact = std::exp(std::min(87., static_cast<double>(x[i])));
    EXPECT_NEAR(std::min(rising[i], 6e37f) / std::min(exact, 6e37), 1, 1e-5) << x[i];
    EXPECT_NEAR(falling[i], 1 / exact, 1e-6) << x[i];
    EXPECT_NEAR(logarithms[i], std::log(3 * static_cast<double>(x[i])), 1e-5) << x[i];
    EXPECT_NEAR(errors[i], std::erf(2 * static_cast<double>(x[i])), 5e-7) << x[i];
  }
}

TEST(ResidualKernels, ScoresAreThoseOfADoubleLoop) {
  for (int count : {1, 7, 33, 1003}) {
    const Problem problem(count, 11);
    const PointColumnsView c = problem.columns.view();
    const Eigen::Matrix3d E = problem.pose.essential(), G = problem.H.inverse();
    double cost = 0, transfer_cost = 0;
    int inliers = 0;
    for (int i = 0; i < count; ++i) {
      const double e = c.weight[i] * sampsonSquared(E, c.x1[i], c.y1[i], c.x2[i], c.y2[i]);
      cost += std::min(e, 1.0);
      inliers += e < 1;
      transfer_cost += std::min(1.0, c.weight[i] * transferSquared(problem.H, G, c.x1[i], c.y1[i], c.x2[i], c.y2[i]));
    }
    const FloatMatrix h(problem.H), g(G);
    for (SimdLevel level : supportedLevels()) {
      HypothesisScore score, transfer;
      residualKernels(level).scoreEpipolar(c, problem.pose.parameters().E, 1e9f, score);
      EXPECT_NEAR(cost, score.cost, 1e-3 * (1 + cost));
      EXPECT_NEAR(inliers, score.inliers, 1);  // float may flip a match at the very threshold
      EXPECT_EQ(count, score.evaluated);
      residualKernels(level).scoreHomography(c, h.entry, g.entry, 1e9f, transfer);
      EXPECT_NEAR(transfer_cost, transfer.cost, 1e-3 * (1 + transfer_cost));
    }
  }
}

TEST(ResidualKernels, ThePoseScoreSumsUpResidualsAndPointsBehindTheCameraLose) {
  const Problem problem(500, 16);
  const PointColumnsView points = problem.columns.view();
  const ResidualKernels& kernels = residualKernels(detectSimdLevel());
  HypothesisScore epipolar, scores[2];
  kernels.scoreEpipolar(points, problem.pose.parameters().E, 1e9f, epipolar);
  for (const int behind : {0, 1}) {
    const PoseParameters pose = TwoViewPose{problem.pose.R, (behind ? -1 : 1) * problem.pose.t}.parameters();
    kernels.scorePose(points, pose, {}, 1e9f, scores[behind]);
    std::vector<float> e(static_cast<size_t>(points.size));
    kernels.poseResiduals(points, pose, e.data());
    double cost = 0;
    int inliers = 0;
    for (size_t i = 0; i < 500; ++i) {
      cost += std::min(1.f, e[i]);
      inliers += e[i] < 1;
    }
    EXPECT_NEAR(cost, scores[behind].cost, 1e-4 * cost);
    EXPECT_EQ(inliers, scores[behind].inliers);
  }
  EXPECT_NEAR(epipolar.inliers, scores[0].inliers, 10);
  EXPECT_LT(scores[1].inliers, scores[0].inliers / 4);
}

TEST(ResidualKernels, ThePriorCostsNothingWhereAMatchIsIgnored) {
  Problem problem(200, 19);
  for (int i = 0; i < 200; ++i) problem.columns.y2()[i] += 0.3f;  // off every epipolar line by far
  problem.pose.t = {1, 0, 0};
  const Loss loss = {4, 1};
  NormalEquations<5> without, with;
  PoseModel(residualKernels(detectSimdLevel()), problem.columns.view()).linearize(problem.pose, loss, without);
  PoseModel(residualKernels(detectSimdLevel()), problem.columns.view(), {0.1f, 0.05f})
      .linearize(problem.pose, loss, with);
  ASSERT_EQ(without.weight, 0);
  EXPECT_NEAR(without.cost, 200 * 4 / 5.0, 1e-2);
  EXPECT_EQ(with.cost, without.cost);
}

TEST(ResidualKernels, CostsAloneAreThoseOfTheNormalEquations) {
  const Problem problem(1003, 20);
  const PointColumnsView points = problem.columns.view();
  const PoseParameters pose = problem.pose.parameters();
  const float basis[2][3] = {{1, 0, 0}, {0, 1, 0}}, of_matrix[7][9] = {};
  for (const SimdLevel level : supportedLevels()) {
    const ResidualKernels& kernels = residualKernels(level);
    for (const Loss& loss : {Loss{1, 0}, Loss{4, 1}}) {
      for (const ParallaxPrior& prior : {ParallaxPrior{}, ParallaxPrior{0.1f, 0.05f}}) {
        NormalEquations<5> equations;
        kernels.linearizePose(points, pose, basis, loss, prior, equations);
        EXPECT_EQ(equations.cost, kernels.poseCost(points, pose, loss, prior)) << toString(level);
      }
      NormalEquations<7> of_lines;
      kernels.linearizeFundamental(points, pose.E, of_matrix, loss, of_lines);
      EXPECT_EQ(of_lines.cost, kernels.epipolarCost(points, pose.E, loss)) << toString(level);
      NormalEquations<3> of_transfer;
      kernels.linearizeRotation(points, pose.R, loss, of_transfer);
      EXPECT_EQ(of_transfer.cost, kernels.transferCost(points, pose.R, loss)) << toString(level);
    }
  }
}

TEST(PoseModel, HypothesesAreRotations) {
  // Samples of a rotating camera, whose roots are the least accurate.
  constexpr int kSamples = 4000;
  Problem problem(5 * kSamples, 16);
  std::mt19937 generator(17);
  std::normal_distribution<float> noise(0, 1e-3f);
  for (int i = 0; i < 5 * kSamples; ++i) {
    const Eigen::Vector3d turned =
        problem.pose.R * Eigen::Vector3d(problem.columns.x1()[i], problem.columns.y1()[i], 1);
    problem.columns.x2()[i] = static_cast<float>(turned.x() / turned.z()) + noise(generator);
    problem.columns.y2()[i] = static_cast<float>(turned.y() / turned.z()) + noise(generator);
  }
  const PoseModel model(residualKernels(SimdLevel::kScalar), problem.columns.view());
  int count = 0;
  double worst = 0;
  for (int k = 0; k < kSamples; ++k) {
    const int sample[5] = {5 * k, 5 * k + 1, 5 * k + 2, 5 * k + 3, 5 * k + 4};
    Hypothesis hypotheses[kMaxHypotheses];
    const int found = model.solve(sample, hypotheses);
    for (int h = 0; h < found; ++h) {
      const Eigen::Matrix3d& R = hypotheses[h].pose.R;
      worst = std::max(worst, (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff());
      EXPECT_GT(R.determinant(), 0);
    }
    count += found;
  }
  EXPECT_GT(count, kSamples);
  EXPECT_LT(worst, 1e-12);
}

TEST(PoseModel, RefinementEndsInARotationWhereverItStarts) {
  const Problem problem(200, 18);
  const PoseModel model(residualKernels(SimdLevel::kScalar), problem.columns.view());
  for (const int iterations : {0, 10}) {
    TwoViewPose pose = problem.pose;
    pose.R(0, 1) += 2.5e-3;
    model.refine({4, 1}, iterations, pose);
    EXPECT_LT((pose.R * pose.R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
  }
}

/// The gradient of the linearised cost is that of the cost itself.
TEST(ResidualKernels, GradientIsThatOfTheCost) {
  Problem problem(400, 15);
  for (const ParallaxPrior& prior : {ParallaxPrior{}, ParallaxPrior{0.1f, 0.05f}}) {
    const PoseModel model(residualKernels(SimdLevel::kScalar), problem.columns.view(), prior);
    TwoViewPose pose = problem.pose;
    pose.R = rotationFromVector({2e-3, -1e-3, 1e-3}) * pose.R;
    const Loss loss = {1e6f, 1};
    NormalEquations<5> equations, plus, minus;
    model.linearize(pose, loss, equations);
    Eigen::Vector3d basis[2];
    PoseModel::tangent(pose.t, basis);
    for (int k = 0; k < 5; ++k) {
      constexpr double kStep = 2e-4;
      const auto moved = [&](double step) {
        TwoViewPose to = pose;
        if (k < 3) to.R = rotationFromVector(step * Eigen::Vector3d::Unit(k)) * pose.R;
        if (k >= 3) to.t = (pose.t + step * basis[k - 3]).normalized();
        return to;
      };
      model.linearize(moved(kStep), loss, plus);
      model.linearize(moved(-kStep), loss, minus);
      const double numeric = (plus.cost - minus.cost) / (2 * kStep);
      EXPECT_NEAR(numeric, 2 * equations.gradient[k], 0.03 * std::abs(numeric) + 30) << "parameter " << k;
    }
  }
}

}  // namespace
}  // namespace gms_ransac
