// Everything a table of residual kernels computes, as numbers to compare. Free of Eigen and of a test framework, so
// that it can be cross-compiled.
#pragma once

#include <random>
#include <vector>

#include "two_view/kernels/residual_kernels.h"

namespace gms_ransac {

inline std::vector<float> allResults(const ResidualKernels& kernels, const PointColumnsView& points,
                                     const PoseParameters& pose, const float (&H)[9], const float (&G)[9]) {
  float D[8][9];
  std::mt19937 generator(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (auto& row : D) {
    for (float& entry : row) entry = uniform(generator);
  }
  std::vector<float> results;
  const auto add = [&results](const auto& values) {
    const auto* first = reinterpret_cast<const float*>(&values);
    results.insert(results.end(), first, first + sizeof(values) / sizeof(float));
  };
  const ParallaxPrior prior = {0.03f, 0.05f};
  for (float bound : {1e9f, 0.3f * static_cast<float>(points.count)}) {
    HypothesisScore score;
    const auto addScore = [&] {
      add(score.cost);
      results.push_back(static_cast<float>(score.inliers));
      results.push_back(static_cast<float>(score.evaluated));
    };
    kernels.scoreEpipolar(points, pose.E, bound, score);
    addScore();
    kernels.scorePose(points, pose, prior, bound, score);
    addScore();
    kernels.scoreHomography(points, H, G, bound, score);
    addScore();
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
    kernels.linearizeRotation(points, pose.R, reinterpret_cast<const float(&)[3][9]>(D), loss, three);
    add(three);
    add(kernels.poseCost(points, pose, loss, prior));
    add(kernels.poseCost(points, pose, loss, {}));
    add(kernels.epipolarCost(points, pose.E, loss));
    add(kernels.transferCost(points, H, loss));
  }
  std::vector<float> e(static_cast<size_t>(points.size));
  kernels.epipolarResiduals(points, pose.E, e.data());
  results.insert(results.end(), e.begin(), e.begin() + points.count);
  kernels.poseResiduals(points, pose, e.data());
  results.insert(results.end(), e.begin(), e.begin() + points.count);
  kernels.transferResiduals(points, H, e.data());
  results.insert(results.end(), e.begin(), e.begin() + points.count);
  return results;
}

}  // namespace gms_ransac
