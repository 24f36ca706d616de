// The pipeline as its callers see it.
#include "gms_ransac/match_filter.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace gms_ransac
