// The matcher against a double loop: every instruction set, ties, odd sizes, both directions, several threads.
#include "gms_ransac/hamming_matcher.h"

#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "double_loop.h"
#include "simd_levels.h"

namespace gms_ransac {
namespace {

DescriptorSet setOf(std::vector<uint8_t>& rows) {
  DescriptorSet set;
  set.assign(cv::Mat(static_cast<int>(rows.size()) / kDescriptorBytes, kDescriptorBytes, CV_8U, rows.data()));
  return set;
}

/// Two drawn sets, and their matches in one direction and in both.
struct Problem {
  DescriptorSet reference, current;
  std::vector<Match> nearest, mutual;

  Problem(int references, int currents, Bits bits, uint32_t seed) {
    std::vector<uint8_t> queries = drawDescriptors(references, bits, seed);
    std::vector<uint8_t> train = drawDescriptors(currents, bits, seed + 1);
    reference = setOf(queries);
    current = setOf(train);
    const std::vector<NearestTwo> truth = nearestByDoubleLoop(queries, train);
    const std::vector<NearestTwo> reverse = nearestByDoubleLoop(train, queries);
    for (int i = 0; currents > 0 && i < references; ++i) {
      const NearestTwo& two = truth[i];
      nearest.push_back({i, two.index, two.distance, two.second_distance});
      if (reverse[two.index].index == i) mutual.push_back(nearest.back());
    }
  }
};

void expectEqual(const std::vector<Match>& expected, const std::vector<Match>& found) {
  ASSERT_EQ(expected.size(), found.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    const auto values = [](const Match& m) { return std::tie(m.reference, m.current, m.distance, m.second_distance); };
    ASSERT_EQ(values(expected[i]), values(found[i])) << "match " << i;
  }
}

void compare(int references, int currents, Bits bits, uint32_t seed) {
  Problem problem(references, currents, bits, seed);
  for (const SimdLevel level : supportedLevels()) {
    SCOPED_TRACE(toString(level) + ", " + std::to_string(references) + " x " + std::to_string(currents) + ", bits " +
                 std::to_string(static_cast<int>(bits)));
    problem.current.pack(level);
    for (int threads : {1, 2, 5}) {
      std::vector<Match> found;
      HammingMatcher({false, threads, level}).match(problem.reference, problem.current, found);
      expectEqual(problem.nearest, found);
      HammingMatcher({true, threads, level}).match(problem.reference, problem.current, found);
      expectEqual(problem.mutual, found);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(HammingMatcher, EqualsDoubleLoop) {
  for (Bits bits : kAllBits) {
    for (int references : {0, 1, 7, 33, 600}) {
      for (int currents : {0, 1, 2, 7, 33, 127, 128, 129, 256, 600}) compare(references, currents, bits, 17);
    }
  }
  // Beyond one run.
  compare(4097, 333, Bits::kTwoBytes, 4);
  compare(4097, 65, Bits::kAllEqual, 4);
  compare(9, 70000, Bits::kTwoBytes, 8);
}

TEST(HammingMatcher, StorageIsReusedAcrossSizes) {
  HammingMatcher matcher({true, 1, detectSimdLevel()});
  std::vector<Match> found;
  for (int n : {900, 1, 33, 0, 500}) {
    const Problem problem(n, n + 5, Bits::kTwoBytes, 1);
    matcher.match(problem.reference, problem.current, found);
    expectEqual(problem.mutual, found);
  }
}

TEST(HammingMatcher, RefusesBadOptionsAndDescriptors) {
  HammingMatcherOptions options;
  options.threads = 65;
  EXPECT_THROW(HammingMatcher{options}, std::invalid_argument);
  std::vector<uint8_t> rows(kDescriptorBytes);
  const DescriptorSet good = setOf(rows);
  std::vector<Match> found;
  for (const cv::Mat& other : {cv::Mat(cv::Mat::zeros(3, 31, CV_8U)), cv::Mat(cv::Mat::zeros(3, 32, CV_32F))}) {
    DescriptorSet set;
    set.assign(other);
    EXPECT_THROW(HammingMatcher().match(good, set, found), std::invalid_argument);
    EXPECT_THROW(HammingMatcher().match(set, good, found), std::invalid_argument);
  }
}

}  // namespace
}  // namespace gms_ransac
