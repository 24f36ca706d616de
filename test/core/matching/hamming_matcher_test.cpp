// The matcher against a double loop: every instruction set, ties, odd sizes, both directions, two threads.
#include "gms_ransac/hamming_matcher.h"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "matching/hamming_kernels.h"
#include "simd_levels.h"

namespace gms_ransac {
namespace {

/// How random the bits are decides how many ties there are.
enum class Bits { kRandom, kTwoBytes, kAllEqual, kOpposite };

DescriptorSet makeDescriptors(int n, Bits bits, uint32_t seed) {
  std::mt19937 random(seed);
  cv::Mat rows(n, kDescriptorBytes, CV_8U, cv::Scalar(0x5a));
  for (int i = 0; i < n; ++i) {
    uint8_t* row = rows.ptr(i);
    if (bits == Bits::kRandom) {
      for (int b = 0; b < kDescriptorBytes; ++b) row[b] = static_cast<uint8_t>(random());
    } else if (bits == Bits::kTwoBytes) {
      row[random() % kDescriptorBytes] = static_cast<uint8_t>(random());
      row[random() % kDescriptorBytes] = static_cast<uint8_t>(random());
    } else if (bits == Bits::kOpposite) {
      // Two complementary patterns, sometimes one bit off: distances of 0, 1, 255 and 256.
      for (int b = 0; b < kDescriptorBytes; ++b) row[b] = seed % 2 ? 0x0f : 0xf0;
      if (random() % 16 == 0) row[random() % kDescriptorBytes] ^= 1;
    }
  }
  DescriptorSet set;
  set.assign(rows);
  return set;
}

struct Truth {
  std::vector<Match> nearest, mutual;
};

Truth doubleLoop(const DescriptorSet& reference, const DescriptorSet& current) {
  Truth truth;
  if (current.size() == 0) return truth;
  std::vector<int> reverse_distance(current.size(), 257), reverse_index(current.size(), -1);
  for (int i = 0; i < reference.size(); ++i) {
    Match match{i, -1, 257, 257};
    for (int j = 0; j < current.size(); ++j) {
      const int distance = hammingDistance(reference.row(i), current.row(j));
      if (distance < match.distance) {
        match.second_distance = match.distance;
        match.distance = static_cast<uint16_t>(distance);
        match.current = j;
      } else if (distance < match.second_distance) {
        match.second_distance = static_cast<uint16_t>(distance);
      }
      if (distance < reverse_distance[j]) {
        reverse_distance[j] = distance;
        reverse_index[j] = i;
      }
    }
    truth.nearest.push_back(match);
  }
  for (const Match& match : truth.nearest) {
    if (reverse_index[match.current] == match.reference) truth.mutual.push_back(match);
  }
  return truth;
}

void expectEqual(const std::vector<Match>& expected, const std::vector<Match>& found) {
  ASSERT_EQ(expected.size(), found.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(expected[i].reference, found[i].reference) << "match " << i;
    ASSERT_EQ(expected[i].current, found[i].current) << "match " << i;
    ASSERT_EQ(expected[i].distance, found[i].distance) << "match " << i;
    ASSERT_EQ(expected[i].second_distance, found[i].second_distance) << "match " << i;
  }
}

void compare(int references, int currents, Bits bits, uint32_t seed) {
  const DescriptorSet reference = makeDescriptors(references, bits, seed);
  DescriptorSet current = makeDescriptors(currents, bits, seed + 1);
  const Truth truth = doubleLoop(reference, current);
  for (const SimdLevel level : supportedLevels()) {
    SCOPED_TRACE(toString(level) + ", " + std::to_string(references) + " x " + std::to_string(currents) + ", bits " +
                 std::to_string(static_cast<int>(bits)));
    current.pack(level);
    for (int threads : {1, 2, 5}) {
      std::vector<Match> found;
      HammingMatcher({false, threads, level}).match(reference, current, found);
      expectEqual(truth.nearest, found);
      HammingMatcher({true, threads, level}).match(reference, current, found);
      expectEqual(truth.mutual, found);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(HammingMatcher, EqualsDoubleLoopForEverySize) {
  for (Bits bits : {Bits::kRandom, Bits::kTwoBytes, Bits::kAllEqual, Bits::kOpposite}) {
    for (int references : {0, 1, 7, 33, 600}) {
      for (int currents : {0, 1, 2, 7, 33, 127, 128, 129, 256, 600}) compare(references, currents, bits, 17);
    }
  }
}

TEST(HammingMatcher, EqualsDoubleLoopBeyondOneRun) {
  compare(4097, 333, Bits::kTwoBytes, 4);
  compare(4097, 65, Bits::kAllEqual, 4);
  compare(9, 70000, Bits::kTwoBytes, 8);
}

TEST(HammingMatcher, StorageIsReusedAcrossSizes) {
  HammingMatcher matcher({true, 1, detectSimdLevel()});
  DescriptorSet reference, current;
  std::vector<Match> found;
  for (int n : {900, 1, 33, 0, 500}) {
    reference = makeDescriptors(n, Bits::kTwoBytes, 1);
    current = makeDescriptors(n + 5, Bits::kTwoBytes, 2);
    matcher.match(reference, current, found);
    expectEqual(doubleLoop(reference, current).mutual, found);
  }
}

TEST(HammingMatcher, RefusesBadOptionsAndDescriptors) {
  HammingMatcherOptions options;
  options.threads = 65;
  EXPECT_THROW(HammingMatcher{options}, std::invalid_argument);
  DescriptorSet set;
  EXPECT_THROW(set.assign(cv::Mat(3, 31, CV_8U)), std::invalid_argument);
  EXPECT_THROW(set.assign(cv::Mat(3, 32, CV_32F)), std::invalid_argument);
}

}  // namespace
}  // namespace gms_ransac
