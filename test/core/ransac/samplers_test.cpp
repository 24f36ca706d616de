// Orderings, samplers, verifiers and stopping rules one by one, against tables and their definitions.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "methods/cp_ransac.h"
#include "ransac/ordering.h"
#include "ransac/sampler.h"
#include "ransac/verifier.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"
#include "two_view_scene.h"

namespace gms_ransac {
namespace {

/// A mask of n matches with the given number of inliers in front.
std::vector<uint8_t> inliersInFront(int inliers, int n) {
  std::vector<uint8_t> mask(static_cast<size_t>(n), 0);
  std::fill_n(mask.begin(), inliers, 1);
  return mask;
}

void expectDistinctBelow(const int* sample, int count, int limit) {
  EXPECT_EQ(std::set<int>(sample, sample + count).size(), static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    EXPECT_GE(sample[i], 0);
    EXPECT_LT(sample[i], limit);
  }
}

/// How many samples of five ranks below `limit` are drawn until the sampler stops.
int countDraws(Sampler& sampler, int limit) {
  Random random(1);
  int sample[5], draws = 0;
  for (; sampler.draw(random, sample); ++draws) expectDistinctBelow(sample, 5, limit);
  return draws;
}

TEST(RequiredIterations, AreThoseOfTheTableBetweenOneAndTheCap) {
  // k = log(1 - p) / log(1 - w^n), rounded up, worked out apart from the code for p = 0.99 and 0.9999.
  const double ratios[] = {0.5, 0.6, 0.7, 0.8, 0.9};
  const struct {
    int sample_size;
    int at_99[5], at_9999[5];
  } table[] = {
      {4, {72, 34, 17, 9, 5}, {143, 67, 34, 18, 9}},
      {5, {146, 57, 26, 12, 6}, {291, 114, 51, 24, 11}},
      {7, {588, 163, 54, 20, 8}, {1175, 325, 108, 40, 15}},
      {8, {1177, 272, 78, 26, 9}, {2354, 544, 156, 51, 17}},
  };
  for (const auto& row : table) {
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(requiredIterations(0.99, ratios[i], row.sample_size, 100000), row.at_99[i]);
      EXPECT_EQ(requiredIterations(0.9999, ratios[i], row.sample_size, 100000), row.at_9999[i]);
    }
  }
  // Between one and the cap.
  EXPECT_EQ(requiredIterations(0.99, 0, 5, 1234), 1234);
  EXPECT_EQ(requiredIterations(0.99, 1e-9, 5, 1234), 1234);
  EXPECT_EQ(requiredIterations(0.99, 1, 5, 1234), 1);
  EXPECT_EQ(requiredIterations(0.5, 0.99, 5, 1234), 1);
}

TEST(ChanceSupport, LeavesTheSignOfTheGammaFunctionAlone) {
  // std::lgamma writes to this variable of the whole process: a race between two filters.
  constexpr int kMark = 7;
  signgam = kMark;
  ChanceSupport chance;
  for (int n = 5; n < 300; ++n) chance.minimum(5, n);
  EXPECT_EQ(signgam, kMark);
}

TEST(ChanceSupport, IsTheSmallestWithABinomialTailBelowFivePercent) {
  ChanceSupport chance;
  for (int sample_size : {4, 5, 7}) {
    EXPECT_GT(chance.minimum(sample_size, sample_size - 1), sample_size - 1);
    for (int n : {20, 100, 700, 8, 2000}) {  // not in order: the table grows
      const auto tail = [&](int inliers) {
        const int others = n - sample_size;
        double sum = 0;
        for (int k = inliers - sample_size; k <= others; ++k) {
          sum += std::exp(std::lgamma(others + 1.) - std::lgamma(k + 1.) - std::lgamma(others - k + 1.) +
                          k * std::log(0.05) + (others - k) * std::log(0.95));
        }
        return sum;
      };
      const int minimum = chance.minimum(sample_size, n);
      EXPECT_LT(tail(minimum), 0.05) << n;
      EXPECT_GE(tail(minimum - 1), 0.05) << n;
    }
  }
}

TEST(Ordering, SortsByItsKeyThenTheOthersThenTheIndex) {
  TwoViewSceneOptions options;
  options.matches = 3000;
  const PointPairs pairs = makeTwoViewScene(options).pairs;
  const auto ratio = [&](int i) {
    return pairs.second_distance[i] ? pairs.distance[i] * 511 / pairs.second_distance[i] : 511;
  };
  const auto keys = [&](SortKey key, int i) -> std::array<int, 4> {
    if (key == SortKey::kScore) return {-pairs.score[i], pairs.distance[i], std::min(511, ratio(i)), i};
    if (key == SortKey::kDistance) return {pairs.distance[i], std::min(511, ratio(i)), -pairs.score[i], i};
    return {std::min(511, ratio(i)), pairs.distance[i], -pairs.score[i], i};
  };
  Ordering ordering;
  for (SortKey key : {SortKey::kScore, SortKey::kDistance, SortKey::kLoweRatio}) {
    std::vector<int> order, expected(static_cast<size_t>(pairs.size()));
    ordering.sort(pairs, key, order);
    std::iota(expected.begin(), expected.end(), 0);
    std::sort(expected.begin(), expected.end(), [&](int a, int b) { return keys(key, a) < keys(key, b); });
    EXPECT_EQ(order, expected);
  }
  std::vector<int> order;
  ordering.sort(pairs, std::nullopt, order);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

TEST(UniformSampler, DrawsFromAllMatchesUntilTheBound) {
  UniformSampler sampler;
  sampler.begin({100, 5, 0.99, 2000});
  Random random(1);
  int sample[5], draws = 0;
  std::vector<int> times(100, 0);
  while (sampler.draw(random, sample)) {
    expectDistinctBelow(sample, 5, 100);
    for (int rank : sample) ++times[static_cast<size_t>(rank)];
    if (++draws == 1000) sampler.newBest(inliersInFront(30, 100));
  }
  EXPECT_EQ(draws, std::max(1000, requiredIterations(0.99, 0.3, 5, 2000)));
  // 100 expected for each rank with a standard deviation of about 10.
  EXPECT_GT(*std::min_element(times.begin(), times.end()), 50);
  EXPECT_LT(*std::max_element(times.begin(), times.end()), 150);
}

TEST(UniformSampler, StopsAtTheBoundOfItsMatchesOrAtTheTarget) {
  const struct {
    UniformSampler::Options options;
    int n, inliers;  ///< in front
    int limit;       ///< of the ranks that are drawn
    int draws;
  } cases[] = {{{1, 1, {}}, 100, 60, 100, 97},    // log(0.01) / log(1 - 0.6^(5 + d)), for d = 1
               {{1, 2, {}}, 100, 60, 100, 163},   // and 2
               {{0.2, 0, {}}, 200, 20, 40, 146},  // half of the first fifth
               {{1, 0, 0.6}, 100, 59, 100, 63},   // log(0.01) / log(1 - 0.59^5)
               {{1, 0, 0.6}, 100, 60, 100, 0}};
  for (const auto& expected : cases) {
    UniformSampler sampler(expected.options);
    sampler.begin({expected.n, 5, 0.99, 5000});
    sampler.newBest(inliersInFront(expected.inliers, expected.n));
    EXPECT_EQ(countDraws(sampler, expected.limit), expected.draws);
  }
}

TEST(UniformSampler, GoesOnFromTheSamplesOfAnEarlierSearch) {
  for (const int drawn : {0, 60, 200}) {
    UniformSampler sampler;
    sampler.begin({100, 5, 0.99, 5000}, drawn);
    sampler.newBest(inliersInFront(59, 100));
    EXPECT_EQ(countDraws(sampler, 100), std::max(0, 63 - drawn));  // log(0.01) / log(1 - 0.59^5)
  }
}

TEST(ProsacSampler, GrowsByTheTableAndAlwaysTakesTheNewestMatch) {
  // T_n of Chum & Matas 2005 eq. 3 in closed form, T_N prod (n-i)/(N-i), not by the recurrence.
  for (int m : {4, 5, 7}) {
    const int N = 300;
    const auto expected_draws = [&](int n) {
      double T = 200000;
      for (int i = 0; i < m; ++i) T *= static_cast<double>(n - i) / (N - i);
      return T;
    };
    std::vector<int> growth = {1};  // T'_m, T'_{m+1}, ...
    for (int n = m; n < N; ++n) {
      growth.push_back(growth.back() + static_cast<int>(std::ceil(expected_draws(n + 1) - expected_draws(n))));
    }
    ProsacSampler sampler;
    sampler.begin({N, m, 0.99, 20000});
    Random random(3);
    int sample[kMaxSampleSize];
    for (int t = 1; t <= 20000; ++t) {
      ASSERT_TRUE(sampler.draw(random, sample));
      int n = m;
      while (growth[static_cast<size_t>(n - m)] < t) ++n;
      ASSERT_EQ(sampler.prefix(), n) << "draw " << t << ", sample size " << m;
      ASSERT_TRUE(sampler.growing());
      expectDistinctBelow(sample, m, n);
      EXPECT_EQ(std::count(sample, sample + m, n - 1), 1) << "draw " << t;
    }
  }
}

TEST(ProsacSampler, DrawsFromThePrefixOnceItHasStoppedGrowing) {
  const int N = 400, good = 100;
  ProsacSampler sampler;
  sampler.begin({N, 5, 0.99, 100000});
  Random random(3);
  int sample[5];
  ASSERT_TRUE(sampler.draw(random, sample));
  // Half of the first hundred are inliers, none of the others: n* is at most one hundred.
  std::vector<uint8_t> mask(N, 0);
  for (int i = 0; i < good; i += 2) mask[static_cast<size_t>(i)] = 1;
  sampler.newBest(mask);
  int stopped = 0, without_newest = 0, draws = 1;
  while (sampler.draw(random, sample)) {
    ++draws;
    expectDistinctBelow(sample, 5, good);
    if (sampler.growing()) continue;
    ++stopped;
    without_newest += std::count(sample, sample + 5, sampler.prefix() - 1) == 0;
  }
  EXPECT_LE(draws, 146);  // the bound at half inliers
  ASSERT_GT(stopped, 20);
  EXPECT_GT(without_newest, stopped / 2);
}

TEST(ProsacSampler, IgnoresPrefixesThatChanceExplains) {
  ProsacSampler sampler;
  sampler.begin({1000, 5, 0.99, 1000});
  sampler.newBest(inliersInFront(5, 1000));  // the sample itself and nothing else
  EXPECT_EQ(countDraws(sampler, 1000), 1000);
}

TEST(ConfidenceGroupSampler, DrawsOnlyFromTheTopGroupFirst) {
  ConfidenceGroupSampler sampler(0.5, false);
  sampler.begin({201, 5, 0.99, 1000});
  Random random(5);
  int sample[5];
  bool beyond = false;
  for (int draw = 0; draw < 1000; ++draw) {
    const int phase = draw < 500 ? 0 : 1;  // half the cap
    ASSERT_TRUE(sampler.draw(random, sample));
    EXPECT_EQ(sampler.phase(), phase);
    expectDistinctBelow(sample, 5, phase == 0 ? 101 : 201);
    beyond |= *std::max_element(sample, sample + 5) > 100;
  }
  EXPECT_TRUE(beyond);
  EXPECT_FALSE(sampler.draw(random, sample));
}

TEST(ConfidenceGroupSampler, StopsAtTheBoundOfTheBetterGroupUnlessChanceExplainsIt) {
  const struct {
    double fraction;
    int n, first[2], end[2];  ///< of all matches, and of two runs of inliers
    int draws, phase;
  } cases[] = {{0.5, 200, {0, 100}, {80, 120}, 12, 0},  // 0.8 of the top group, 0.5 of all
               {0.5, 200, {60, 0}, {200, 0}, 26, 1},    // 0.4 of the top group, 0.7 of all
               {0.02, 500, {0, 0}, {10, 0}, 1000, 1}};  // all of the top group, but 10 of 500
  for (const auto& expected : cases) {
    ConfidenceGroupSampler sampler(expected.fraction, false);
    sampler.begin({expected.n, 5, 0.99, 1000});
    std::vector<uint8_t> mask(static_cast<size_t>(expected.n), 0);
    for (int k : {0, 1}) std::fill(mask.begin() + expected.first[k], mask.begin() + expected.end[k], 1);
    sampler.newBest(mask);
    EXPECT_EQ(countDraws(sampler, expected.n), expected.draws);
    EXPECT_EQ(sampler.phase(), expected.phase);
  }
}

TEST(ConfidenceGroupSampler, GeometricGroupsWidenStepByStep) {
  ConfidenceGroupSampler sampler(0.5, true);
  sampler.begin({400, 5, 0.99, 1600});
  Random random(5);
  int sample[5];
  const int limits[] = {200, 300, 350, 375, 400};
  while (sampler.draw(random, sample)) expectDistinctBelow(sample, 5, limits[sampler.phase()]);
  EXPECT_EQ(sampler.phase(), 4);
}

TEST(StratifiedSampler, SpreadsSamplesAboutAsWideAsUniformDraws) {
  // Confidence is highest in one corner, as motion statistics are highest in the densest texture.
  constexpr int kCount = 1000, kDraws = 2000;
  Random random(1);
  std::vector<int> order(kCount);
  std::iota(order.begin(), order.end(), 0);
  std::vector<int32_t> cells;
  for (int i = 0; i < kCount; ++i) {
    const int reach = i < kCount / 2 ? 10 : 20;
    cells.push_back(random.below(reach) * 20 + random.below(reach));
  }
  const auto spread = [&cells](const int* sample) {
    double sum = 0;
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < i; ++j) {
        sum += std::hypot(cells[sample[i]] % 20 - cells[sample[j]] % 20, cells[sample[i]] / 20 - cells[sample[j]] / 20);
      }
    }
    return sum;
  };
  StratifiedSampler sampler;
  sampler.begin({kCount, 5, 0.99, 10000}, order, cells);
  double stratified = 0, uniform = 0;
  int sample[5];
  for (int k = 0; k < kDraws; ++k) {
    sampler.draw(random, sample);
    expectDistinctBelow(sample, 5, kCount);
    if (k < 400) continue;  // all matches take part by then
    stratified += spread(sample);
    drawDistinct(random, kCount, 5, sample);
    uniform += spread(sample);
  }
  EXPECT_GE(stratified, 0.98 * uniform);  // every other sample is drawn by rank alone
}

TEST(StratifiedSampler, BeginsWithTheMostConfidentOrTheShareAskedForAndEndsWithAll) {
  std::vector<int> order(400);
  std::iota(order.rbegin(), order.rend(), 0);
  const std::vector<int32_t> cells(order.rbegin(), order.rend());
  StratifiedSampler sampler;
  sampler.begin({400, 5, 0.99, 1000}, order, cells);
  Random random(1);
  int sample[5];
  sampler.draw(random, sample);
  EXPECT_LT(sampler.prefix(), 400);
  expectDistinctBelow(sample, 5, sampler.prefix());
  EXPECT_EQ(countDraws(sampler, 400), 999);
  EXPECT_EQ(400, sampler.prefix());
  sampler.begin({400, 5, 0.99, 64}, order, cells, 0.5);
  sampler.draw(random, sample);
  EXPECT_EQ(200, sampler.prefix());
  EXPECT_EQ(countDraws(sampler, 400), 63);
}

TEST(StratifiedSampler, HitsWhatIsCrowdedInFewCells) {
  // All but 28 of 211 matches are right, and they lie in three neighbouring cells; the others are anywhere.
  constexpr int kCount = 211, kWrong = 28, kDraws = 300;
  Random random(1);
  std::vector<int> order(kCount);
  std::iota(order.begin(), order.end(), 0);
  std::vector<int32_t> cells;
  for (int i = 0; i < kCount; ++i) cells.push_back(i % 7 == 3 && i / 7 < kWrong ? random.below(400) : 210 + i % 3);
  const auto isRight = [](int i) { return !(i % 7 == 3 && i / 7 < kWrong); };
  StratifiedSampler sampler;
  sampler.begin({kCount, 5, 0.99, 10000}, order, cells);
  int sample[5], clean = 0;
  for (int k = 0; k < kDraws; ++k) {
    sampler.draw(random, sample);
    clean += std::all_of(sample, sample + 5, isRight);
  }
  EXPECT_GT(clean, kDraws / 5);
}

/// The true motion of a drawn pair as a hypothesis of the textbook's model, and its slots in the order of the rows.
struct TrueMotion {
  TwoViewScene pair;
  TwoViewPoints points;
  std::vector<int> order;
  Hypothesis truth;
  int64_t evaluations = 0;

  explicit TrueMotion(const TwoViewSceneOptions& scene) : pair(makeTwoViewScene(scene)) {
    points.set(pair.pairs, pair.camera, ModelType::kEssential, 1, 0);
    points.countInto(&evaluations);
    order.resize(pair.correct.size());
    std::iota(order.begin(), order.end(), 0);
    points.toSlots(order);
    truth.matrix = crossMatrix(pair.t) * pair.R;
  }
  EssentialModel model() const { return {residualKernels(detectSimdLevel()), points.view()}; }
};

TEST(Verifier, TddLooksAtAllMatchesOnlyIfItsOwnFit) {
  TwoViewSceneOptions scene;
  scene.outlier_ratio = 0.5;
  scene.noise_px = 0;
  const TrueMotion motion(scene);
  const EssentialModel model = motion.model();
  Random random(1);
  int passed = 0;
  const int trials = 2000;
  for (int i = 0; i < trials; ++i) {
    const int64_t before = motion.evaluations;
    CountingVerifier verifier(model, motion.points.view(), motion.order, 2);
    if (verifier.beatsBest(motion.truth, random)) {
      ++passed;
      EXPECT_EQ(motion.evaluations - before, 2 + motion.points.size());
    } else {
      EXPECT_LE(motion.evaluations - before, 2);
    }
  }
  EXPECT_NEAR(passed, 0.25 * trials, 0.05 * trials);  // w^d, and a few outliers that fit
}

TEST(Verifier, HoldOutJudgesByMatchesThatAreNotSampled) {
  TwoViewSceneOptions scene;
  scene.noise_px = 0.1;
  const TrueMotion motion(scene);
  const EssentialModel model = motion.model();
  const size_t sampled = motion.pair.correct.size() / 5;
  // Leaves the truth only its held-out inliers, or only those that are sampled.
  const auto spoilt = [&](bool first) {
    PointPairs pairs = motion.pair.pairs;
    for (auto* column : {&pairs.x_current, &pairs.y_current}) {
      const auto middle = column->begin() + static_cast<std::ptrdiff_t>(sampled);
      std::fill(first ? column->begin() : middle, first ? middle : column->end(), -1e4f);
    }
    return pairs;
  };
  Random random(1);
  HoldOutVerifier verifier(model, motion.points.view(), motion.order, 0.2);
  EXPECT_TRUE(verifier.beatsBest(motion.truth, random));
  EXPECT_EQ(motion.evaluations, motion.points.size());
  EXPECT_FALSE(verifier.beatsBest(motion.truth, random)) << "it ties with itself";
  TwoViewPoints part;
  part.set(spoilt(true), motion.pair.camera, ModelType::kEssential, 1, 0);
  EXPECT_TRUE(HoldOutVerifier(model, part.view(), motion.order, 0.2).beatsBest(motion.truth, random));
  part.set(spoilt(false), motion.pair.camera, ModelType::kEssential, 1, 0);
  EXPECT_TRUE(HoldOutVerifier(model, part.view(), motion.order, 0.2).beatsBest(motion.truth, random))
      << "among none held out the sampled decide";
}

TEST(Verifier, CostGivesUpOnWhatCannotWin) {
  TwoViewSceneOptions scene;
  const TrueMotion motion(scene);
  const EssentialModel model = motion.model();
  Random random(1);
  CostVerifier verifier(model, motion.points.view());
  EXPECT_TRUE(verifier.beatsBest(motion.truth, random));
  const int64_t whole = motion.evaluations;
  Hypothesis wrong;
  wrong.matrix = crossMatrix(Eigen::Vector3d::UnitY());
  EXPECT_FALSE(verifier.beatsBest(wrong, random));
  EXPECT_LT(motion.evaluations - whole, whole);
}

}  // namespace
}  // namespace gms_ransac
