// The per-frame path of the core allocates nothing once it has seen a frame of each kind.
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "allocation_counter.h"
#include "gms_ransac/match_filter.h"
#include "rendered_scene.h"

namespace gms_ransac {
namespace {

TEST(Allocation, CountsNewAndAlignedNew) {
  const long before = g_allocations;
  std::vector<int> plain(100);
  struct alignas(64) Line {
    char bytes[64];
  };
  std::vector<Line> aligned(3);
  EXPECT_EQ(before + 2, g_allocations);
  EXPECT_EQ(0U, reinterpret_cast<uintptr_t>(aligned.data()) % 64);
}

class PerFrameAllocation : public testing::TestWithParam<std::tuple<int, SearchMode, double>> {};

TEST_P(PerFrameAllocation, IsNoneOnceWarm) {
  std::vector<cv::Mat> images;
  for (int i = 0; i < 4; ++i) images.push_back(renderedFrame(i).image);

  MatchFilterOptions options;
  options.method = "lo_prosac";
  options.extractor.extractor = "simd_orb";
  options.extractor.threads = options.matcher_threads = std::get<int>(GetParam());
  options.search = std::get<SearchMode>(GetParam());
  options.robust.rolling_shutter_readout = std::get<double>(GetParam());
  MatchFilter filter(options);
  filter.setCamera(cameraOf(renderedScene()));
  double stamp = 0;
  const auto status = [&](const cv::Mat& image) { return filter.process(image, cv::Mat(), stamp += 1 / 30.0).status; };
  for (int round = 0; round < 2; ++round) {
    for (const cv::Mat& image : images) status(image);
  }
  const long before = g_allocations;
  for (const cv::Mat& image : images) EXPECT_EQ(Status::kOk, status(image));
  EXPECT_EQ(before, g_allocations);
}

INSTANTIATE_TEST_SUITE_P(Threads, PerFrameAllocation,
                         testing::Combine(testing::Values(1, 2, 4),
                                          testing::Values(SearchMode::kFull, SearchMode::kGuided),
                                          testing::Values(0, 0.02)));

}  // namespace
}  // namespace gms_ransac
