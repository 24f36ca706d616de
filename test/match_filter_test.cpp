// The pipeline as its callers see it.
#include "gms_ransac/match_filter.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace gms_ransac {
namespace {

TEST(MatchFilter, RefusesAnUnknownMethodWithTheKnownOnes) {
  MatchFilterOptions options;
  options.method = "nonsense";
  try {
    MatchFilter filter(options);
    FAIL() << "accepted an unknown method";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("cp_ransac"), std::string::npos);
  }
}

TEST(MatchFilter, FirstImageHasNothingToCompareWith) {
  MatchFilter filter;
  EXPECT_EQ(filter.process(cv::Mat::zeros(480, 640, CV_8UC1)).status, Status::kFirstFrame);
  EXPECT_EQ(filter.process(cv::Mat::zeros(480, 640, CV_8UC1)).status, Status::kTooFewKeypoints);
}

TEST(MatchFilter, EstimatesAgainAsIfTheSeedHadBeenGivenFirst) {
  cv::Mat texture(300, 400, CV_8UC1), image, moved;
  cv::RNG(1).fill(texture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(texture, texture, cv::Size(), 2.0);
  cv::normalize(texture, image, 0, 255, cv::NORM_MINMAX);
  const cv::Matx33d motion(0.98, -0.1, 30, 0.1, 0.98, -12, 1e-5, 2e-5, 1);
  cv::warpPerspective(image, moved, motion, image.size());

  MatchFilterOptions options;
  options.method = "ransac";
  options.robust.model = ModelType::kHomography;
  options.robust.max_iterations = 5;  // few enough that seeds differ
  options.robust.seed = 7;
  MatchFilter expected_filter(options);
  options.robust.seed = 0;
  MatchFilter filter(options);
  Frame reference, current;
  filter.extract(image, reference);
  filter.extract(moved, current);
  MatchResult expected, result;
  expected_filter.filter(reference, current, expected);
  filter.filter(reference, current, result);
  filter.estimateAgain(7, result);
  EXPECT_GT(expected.inliers, 0);
  EXPECT_EQ(result.status, expected.status);
  EXPECT_EQ(result.inliers, expected.inliers);
  EXPECT_EQ(result.stage, expected.stage);
  EXPECT_EQ(result.robust.model, expected.robust.model);
}

}  // namespace
}  // namespace gms_ransac
