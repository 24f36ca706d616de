// Descriptors that the Hamming kernels do not compare: other lengths against a double loop, floats against a known
// truth.
#include "matching/any_matcher.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "matching/hamming_kernels.h"
#include "says.h"

namespace gms_ransac {
namespace {

DescriptorSet setOfRows(const cv::Mat& rows) {
  DescriptorSet set;
  set.assign(rows);
  return set;
}

template <typename Work>
std::string complaintOf(const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no complaint";
}

cv::Mat drawnBytes(int n, int bytes, uint64_t seed) {
  cv::Mat rows(n, bytes, CV_8U);
  cv::RNG(seed).fill(rows, cv::RNG::UNIFORM, 0, 256);
  return rows;
}

int bitsBetween(const cv::Mat& a, const cv::Mat& b) { return static_cast<int>(cv::norm(a, b, cv::NORM_HAMMING)); }

/// Index of the row nearest to `query`; the lowest on ties.
int nearestRow(const cv::Mat& query, const cv::Mat& rows) {
  int best = 0;
  for (int j = 1; j < rows.rows; ++j) {
    if (bitsBetween(query, rows.row(j)) < bitsBetween(query, rows.row(best))) best = j;
  }
  return best;
}

TEST(AnyMatcher, FindsTheMutualNeighboursOfBinaryDescriptors) {
  for (const int bytes : {16, 61, 64}) {
    const cv::Mat queries = drawnBytes(150, bytes, 1);
    cv::Mat train = drawnBytes(170, bytes, 2);
    for (int i = 0; i < 100; ++i) {  // the first hundred are seen again, in the reverse order, with three bits changed
      queries.row(i).copyTo(train.row(99 - i));
      train.at<uint8_t>(99 - i, i % bytes) ^= 0x51;
    }
    std::vector<Match> found;
    matchMutually(setOfRows(queries), setOfRows(train), found);
    size_t k = 0;
    for (int i = 0; i < queries.rows; ++i) {
      const int j = nearestRow(queries.row(i), train);
      if (nearestRow(train.row(j), queries) != i) continue;
      ASSERT_LT(k, found.size());
      EXPECT_EQ(found[k].reference, i);
      EXPECT_EQ(found[k].current, j);
      const double per_bit = 256. / (8 * bytes);
      EXPECT_EQ(found[k].distance, std::lround(per_bit * bitsBetween(queries.row(i), train.row(j))));
      std::vector<int> bits;
      for (int other = 0; other < train.rows; ++other) bits.push_back(bitsBetween(queries.row(i), train.row(other)));
      std::nth_element(bits.begin(), bits.begin() + 1, bits.end());
      EXPECT_EQ(found[k++].second_distance, std::lround(per_bit * bits[1]));
    }
    EXPECT_EQ(k, found.size()) << bytes << " bytes";
    EXPECT_GE(k, 100u);
  }
}

TEST(AnyMatcher, FindsFloatsByTheirDistanceWhateverTheirLength) {
  constexpr int kCount = 60, kNumbers = 128;
  for (const double length : {1., 512.}) {  // SuperPoint's and SIFT's
    // Perpendicular vectors, the same ones in the reverse order, each with a part of the next one.
    cv::Mat reference = cv::Mat::zeros(kCount, kNumbers, CV_32F), current = reference.clone();
    for (int i = 0; i < kCount; ++i) {
      reference.at<float>(i, i) = static_cast<float>(length);
      current.at<float>(kCount - 1 - i, i) = static_cast<float>(length * 0.8);
      current.at<float>(kCount - 1 - i, kNumbers - 1) = static_cast<float>(length * 0.6);
    }
    std::vector<Match> found;
    matchMutually(setOfRows(reference), setOfRows(current), found);
    ASSERT_EQ(found.size(), static_cast<size_t>(kCount));
    for (int i = 0; i < kCount; ++i) {
      const Match& match = found[static_cast<size_t>(i)];
      EXPECT_EQ(match.reference, i);
      EXPECT_EQ(match.current, kCount - 1 - i);
      EXPECT_EQ(match.distance, std::lround(128 * std::sqrt((0.04 + 0.36) / 2)));
      EXPECT_EQ(match.second_distance, 128) << "perpendicular";
    }
  }
}

TEST(AnyMatcher, OneDescriptorHasNoSecond) {
  std::vector<Match> found;
  const cv::Mat one = cv::Mat::ones(1, 4, CV_32F);
  matchMutually(setOfRows(one), setOfRows(one), found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].distance, 0);
  EXPECT_EQ(found[0].second_distance, kNoDistance);
  matchMutually(setOfRows(one), setOfRows(cv::Mat()), found);
  EXPECT_TRUE(found.empty());
}

TEST(AnyMatcher, SurvivesHugeAndEqualNumbers) {
  constexpr float kHuge = 3e38f;  // the square is not finite
  std::vector<Match> found;
  for (const float value : {0.f, kHuge}) {
    const cv::Mat rows(20, 8, CV_32F, cv::Scalar(value)), others = -rows;
    matchMutually(setOfRows(rows), setOfRows(others), found);
    EXPECT_LE(found.size(), 1u);
    for (const Match& match : found) EXPECT_LE(match.distance, 256);
  }
}

TEST(AnyMatcher, SaysWhatCannotBeCompared) {
  const DescriptorSet orb = setOfRows(drawnBytes(9, 32, 1)), akaze = setOfRows(drawnBytes(9, 61, 1)),
                      sift = setOfRows(cv::Mat::ones(9, 128, CV_32F));
  std::vector<Match> found;
  EXPECT_TRUE(says(complaintOf([&] { matchMutually(akaze, sift, found); }), {"61 bytes", "128 floats"}));
  EXPECT_TRUE(says(complaintOf([&] { matchMutually(orb, akaze, found); }), {"32 bytes", "61 bytes"}));
  EXPECT_TRUE(says(complaintOf([&] { HammingMatcher().match(orb, sift, found); }), {"32 bytes", "128 floats"}));
}

TEST(DescriptorSet, RefusesWhatIsNoDescriptor) {
  cv::Mat numbers = cv::Mat::ones(5, 64, CV_32F);
  numbers.at<float>(3, 7) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(says(complaintOf([&] { setOfRows(numbers); }), {"descriptor 3 has a number that is not finite"}));
  EXPECT_TRUE(says(complaintOf([&] { setOfRows(cv::Mat::ones(5, 64, CV_64F)); }), {"CV_8U", "CV_32F"}));
}

TEST(DescriptorSet, TakesAnotherKindAfterTheFirst) {
  DescriptorSet set = setOfRows(cv::Mat::ones(9, 128, CV_32F));
  EXPECT_EQ(set.kind(), "128 floats");
  const cv::Mat rows = drawnBytes(4, 32, 1);
  set.assign(rows);
  EXPECT_TRUE(set.is256Bit());
  EXPECT_EQ(set.kind(), "32 bytes");
  EXPECT_EQ(cv::norm(set.asMat(), rows, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace gms_ransac
