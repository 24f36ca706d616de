// Points that are aligned, in images whose shift is exact.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "gms_ransac/match_filter.h"
#include "support/order_statistics.h"
#include "support/random.h"

namespace gms_ransac {
namespace {

const cv::Size kAlignedSize(480, 360);

/// Smooth blobs of many sizes, seen from (x, y).
cv::Mat blobsSeenFrom(const cv::Point2d& place) {
  Random random(3);
  cv::Mat sum(kAlignedSize, CV_32F, cv::Scalar(120));
  for (int blob = 0; blob < 1500; ++blob) {
    const double x = 500 * random.uniform() - 10 - place.x, y = 380 * random.uniform() - 10 - place.y;
    const double radius = 1.5 + 4 * random.uniform() * random.uniform(), height = 160 * (random.uniform() - 0.5);
    const int reach = static_cast<int>(4 * radius);
    for (int v = std::max(0, static_cast<int>(y) - reach);
         v < std::min(kAlignedSize.height, static_cast<int>(y) + reach); ++v)
      for (int u = std::max(0, static_cast<int>(x) - reach);
           u < std::min(kAlignedSize.width, static_cast<int>(x) + reach); ++u)
        sum.at<float>(v, u) +=
            static_cast<float>(height * std::exp(-((u - x) * (u - x) + (v - y) * (v - y)) / (2 * radius * radius)));
  }
  cv::Mat image;
  sum.convertTo(image, CV_8U);
  return image;
}

/// Median distance of the inliers' current points, aligned or not, from where the shift takes them.
float medianError(const MatchFilter& filter, const MatchResult& result, const cv::Point2f& shift, bool aligned) {
  std::vector<float> errors;
  for (size_t row = 0; row < result.matches.size(); ++row) {
    if (!result.isInlier(row) || result.pairs.isAligned(row) != aligned) continue;
    const cv::Point2f& keypoint = filter.reference().features.keypoints[result.matches[row].reference].pt;
    errors.push_back(static_cast<float>(cv::norm(result.current_pixel[row] - keypoint - shift)));
  }
  EXPECT_GT(errors.size(), 20U);
  return nthSmallest(errors, errors.size() / 2);
}

MatchFilterOptions homographies() {
  MatchFilterOptions options;
  options.robust.model = ModelType::kHomography;
  return options;
}

TEST(Alignment, FindsPointsToAFewHundredthsOfAPixel) {
  const cv::Point2f shift(-2.3F, 1.6F);
  MatchFilter filter(homographies());
  filter.process(blobsSeenFrom({0, 0}));
  const MatchResult& result = filter.process(blobsSeenFrom({2.3, -1.6}));
  ASSERT_EQ(result.status, Status::kUncalibrated);
  const float aligned = medianError(filter, result, shift, true), keypoints = medianError(filter, result, shift, false);
  EXPECT_LT(aligned, 0.05F);
  EXPECT_GT(keypoints, 4 * aligned);
}

TEST(Alignment, TakesSomeOfEveryPartOfTheView) {
  MatchFilter filter(homographies());
  filter.process(blobsSeenFrom({0, 0}));
  const MatchResult& result = filter.process(blobsSeenFrom({4.5, 0}));
  std::vector<int> matches(kSpreadGridSide * kSpreadGridSide), aligned(matches);
  for (size_t row = 0; row < result.matches.size(); ++row) {
    const auto cell = static_cast<size_t>(spreadCell(result.current_pixel[row], kAlignedSize));
    ++matches[cell];
    aligned[cell] += result.pairs.isAligned(row);
  }
  const auto all = std::count(result.pairs.aligned.begin(), result.pairs.aligned.end(), 1);
  EXPECT_LE(all, 300);
  EXPECT_GT(all, 150);
  int occupied = 0, without = 0;
  for (size_t cell = 0; cell < matches.size(); ++cell) {
    occupied += matches[cell] > 0;
    without += matches[cell] > 0 && aligned[cell] == 0;
  }
  EXPECT_LT(without, occupied / 5);
}

TEST(Alignment, IsSwitchedOffAndNeedsImages) {
  MatchFilterOptions options = homographies();
  options.align_points = false;
  MatchFilter off(options), on(homographies());
  for (const double place : {0., 2.3}) off.process(blobsSeenFrom({place, 0}));
  const MatchResult& plain = off.process(blobsSeenFrom({4.6, 0}));
  EXPECT_TRUE(plain.pairs.aligned.empty());
  EXPECT_EQ(plain.robust.judgement.aligned_sigma_px, plain.robust.judgement.sigma_px);
  on.process(off.reference().features);
  const MatchResult& given = on.process(off.current().features);
  EXPECT_TRUE(given.pairs.aligned.empty());
  for (size_t row = 0; row < given.matches.size(); ++row)
    EXPECT_EQ(given.current_pixel[row], on.current().features.keypoints[given.matches[row].current].pt);
}

TEST(Alignment, KnowsHowPreciseItIs) {
  MatchFilter filter(homographies());
  filter.process(blobsSeenFrom({0, 0}));
  const Judgement& judgement = filter.process(blobsSeenFrom({2.3, -1.6})).robust.judgement;
  EXPECT_GT(judgement.aligned_sigma_px, 0);
  EXPECT_LT(judgement.aligned_sigma_px, 0.5 * judgement.sigma_px);
}

TEST(Alignment, ACopyOfAFrameKeepsItsImage) {
  MatchFilter filter(homographies());
  Frame frame;
  filter.extract(blobsSeenFrom({0, 0}), frame);
  const Frame copy = frame;
  filter.extract(blobsSeenFrom({9, 0}), frame);
  EXPECT_EQ(cv::norm(copy.image, blobsSeenFrom({0, 0}), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(frame.image, blobsSeenFrom({9, 0}), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace gms_ransac
