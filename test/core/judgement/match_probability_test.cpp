// The probability of a match is the share of such matches that are right: on drawn keypoints. Most are at their
// corner, some next to it, and some anywhere.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "judgement/match_noise.h"

namespace gms_ransac {
namespace {

constexpr double kRightWithin = 3;  ///< thresholds

/// Matches of these squared residuals, each of weight 1 unless given, and their noise.
struct Weighed {
  MatchNoise noise{residualKernels(detectSimdLevel())};
  PointColumns columns;

  explicit Weighed(const std::vector<float>& squares) : Weighed(squares, std::vector<float>(squares.size(), 1)) {}
  Weighed(const std::vector<float>& squares, const std::vector<float>& weights) {
    const auto count = static_cast<int>(squares.size());
    columns.resize(count);
    std::copy(weights.begin(), weights.end(), columns.weight());
    noise.measure(squares, count);
  }
  const std::vector<float>& answers(const std::vector<uint8_t>& of_other = {}) {
    return noise.weigh(columns.view(), 1, of_other);
  }
};

struct Keypoints {
  double sigma = 0.3, beside = 0.1, wrong = 0.2;  ///< noise in thresholds; shares
  double coarse = 1;                              ///< of every second match, times the noise
};

/// Expected calibration error of drawn matches, ten bins.
double calibrationError(const Keypoints& drawn) {
  constexpr int kMatches = 4000, kBins = 10;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<float> squares, weights;
  std::vector<bool> right;
  for (int i = 0; i < kMatches; ++i) {
    const double stretch = i % 2 == 0 ? 1 : drawn.coarse, kind = uniform(random);
    const double sigma = kind < drawn.beside ? std::max(1., 2 * drawn.sigma) : drawn.sigma;
    // Error of one keypoint against the other, across the epipolar line and along it.
    double across = std::sqrt(2) * sigma * stretch * normal(random);
    const double along = std::sqrt(2) * sigma * stretch * normal(random);
    right.push_back(kind < 1 - drawn.wrong && std::hypot(across, along) < kRightWithin);
    if (kind >= 1 - drawn.wrong) across = 20 * (2 * uniform(random) - 1) * stretch;
    squares.push_back(static_cast<float>(0.5 * across * across / (stretch * stretch)));
    weights.push_back(static_cast<float>(1 / (stretch * stretch)));
  }
  Weighed weighed(squares, weights);
  const std::vector<float>& answers = weighed.answers();
  std::array<double, kBins> excess = {};
  for (size_t i = 0; i < right.size(); ++i) {
    const auto p = static_cast<double>(answers[i]);
    EXPECT_TRUE(p >= 0 && p <= 1) << p;
    excess[std::min<size_t>(kBins - 1, static_cast<size_t>(kBins * p))] += p - (right[i] ? 1 : 0);
  }
  double error = 0;
  for (const double bin : excess) error += std::abs(bin) / kMatches;
  return error;
}

/// Probabilities of matches of a camera that moves sideways, those of every second one twice as coarse and every
/// tenth wrong, in the order in which they come or backwards.
std::vector<float> ofSidewaysMotion(bool backwards) {
  constexpr int kMatches = 500;
  constexpr float kThreshold = 0.003f;
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 0.5f * kThreshold);
  std::uniform_real_distribution<float> place(-0.5f, 0.5f), step(0.01f, 0.05f);
  Weighed weighed(std::vector<float>(kMatches, 0));
  PointColumns& columns = weighed.columns;
  for (int i = 0; i < kMatches; ++i) {
    const int at = backwards ? kMatches - 1 - i : i, coarse = 1 + i % 2;
    const float x = place(random), y = place(random), moved = step(random);
    columns.x1()[at] = x;
    columns.y1()[at] = y;
    columns.x2()[at] = i % 10 == 0 ? place(random) : x + moved;
    columns.y2()[at] = y + noise(random) * static_cast<float>(coarse);
    columns.weight()[at] = 1 / (kThreshold * kThreshold * static_cast<float>(coarse * coarse));
  }
  weighed.noise.measure(PoseModel(residualKernels(detectSimdLevel()), columns.view()),
                        {Eigen::Matrix3d::Identity(), Eigen::Vector3d::UnitX()});
  std::vector<float> answers = weighed.noise.weigh(columns.view(), 1 / (kThreshold * kThreshold));
  answers.resize(kMatches);
  if (backwards) std::reverse(answers.begin(), answers.end());
  return answers;
}

TEST(MatchProbability, DoesNotDependOnWhichMatchIsFirst) {
  const std::vector<float> answers = ofSidewaysMotion(false), backwards = ofSidewaysMotion(true);
  for (size_t i = 0; i < answers.size(); ++i) EXPECT_NEAR(answers[i], backwards[i], 2e-4) << i;
}

TEST(MatchProbability, IsTheShareOfRightMatches) {
  for (const double sigma : {0.2, 0.5, 1.0}) {
    for (const double wrong : {0.0, 0.2, 0.5}) {
      for (const double coarse : {1.0, 2.0}) {
        const std::string what = std::to_string(sigma) + " " + std::to_string(wrong) + " " + std::to_string(coarse);
        EXPECT_LT(calibrationError({sigma, 0.1, wrong, coarse}), 0.04) << what;
        RecordProperty("error_" + what, std::to_string(calibrationError({sigma, 0.1, wrong, coarse})));
      }
    }
  }
}

TEST(MatchProbability, AKeypointBesideItsCornerIsStillRight) {
  std::vector<float> squares(500, 0.04f);
  for (int i = 0; i < 50; ++i) squares.push_back(1 + 0.01f * static_cast<float>(i));
  squares.push_back(20);
  Weighed weighed(squares);
  const std::vector<float>& answers = weighed.answers();
  EXPECT_LT(weighed.noise.probabilities()[520], 0.1) << "is none of those whose noise that is";
  EXPECT_GT(answers[520], 0.8);
  EXPECT_GT(answers[0], 0.99);
  EXPECT_EQ(answers.back(), 0) << "further away than a right match may be";
}

TEST(MatchProbability, WhatAnotherMotionExplainsHasSharesOfItsOwn) {
  // Cells went to another motion: the matches of most of them follow it, or it explains this motion's as well.
  constexpr int kMatches = 1000, kApart = 300;
  for (const double right_apart : {0.1, 0.5, 0.9}) {
    std::mt19937 random(7);
    std::normal_distribution<float> normal(0, 0.3f);
    std::uniform_real_distribution<float> uniform;
    std::vector<float> squares;
    std::vector<uint8_t> of_other;
    for (int i = 0; i < kMatches; ++i) {
      const bool is_right = uniform(random) < (i < kApart ? right_apart : 0.95);
      const float rho = is_right ? normal(random) : 20 * (2 * uniform(random) - 1);
      squares.push_back(rho * rho);
      of_other.push_back(i < kApart);
    }
    Weighed weighed(squares);
    const std::vector<float>& answers = weighed.answers(of_other);
    EXPECT_NEAR(std::accumulate(answers.begin(), answers.begin() + kApart, 0.) / kApart, right_apart, 0.06);
    EXPECT_NEAR(std::accumulate(answers.begin() + kApart, answers.end(), 0.) / (kMatches - kApart), 0.95, 0.03);
  }
}

TEST(MatchProbability, UnderARotationThePlaceCounts) {
  // All matches lie on the same line; a tenth do not lie where the rotation takes them.
  constexpr int kMatches = 500, kMoved = 50;
  std::mt19937 random(7);
  std::normal_distribution<float> normal(0, 0.3f);
  std::vector<float> squares, places;
  for (int i = 0; i < kMatches; ++i) {
    const float across = normal(random), along = normal(random) + (i < kMoved ? 10.f : 0.f);
    squares.push_back(across * across);
    places.push_back(2 * (across * across + along * along));
  }
  Weighed weighed(squares);
  for (const float p : weighed.answers()) EXPECT_GT(p, 0.9);
  const std::vector<float>& answers = weighed.noise.weigh(weighed.columns.view(), 1, {}, &places);
  for (int i = 0; i < kMatches; ++i) {
    if (i < kMoved) {
      EXPECT_EQ(answers[static_cast<size_t>(i)], 0);
    } else {
      EXPECT_GT(answers[static_cast<size_t>(i)], 0.9);
    }
  }
}

TEST(MatchProbability, MatchesWithoutCoordinatesOrWithoutNumberAreNone) {
  EXPECT_TRUE(Weighed({}).answers().empty());
  Weighed weighed({0, 0}, {1, 0});
  const std::vector<float>& answers = weighed.answers();
  EXPECT_GT(answers[0], 0.5);
  EXPECT_EQ(answers[1], 0);
}

}  // namespace
}  // namespace gms_ransac
