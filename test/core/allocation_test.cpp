// The per-frame path of the core allocates nothing once it has seen a frame of each kind.
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "allocation_counter.h"
#include "gms_ransac/match_filter.h"
#include "methods/method.h"
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

/// Allocations by four images, once a filter with these options has seen them twice. `all_ok`: their pairs must be OK.
long allocationsOf(MatchFilterOptions options, bool all_ok) {
  std::vector<cv::Mat> images;
  for (int i = 0; i < 4; ++i) images.push_back(renderedFrame(i).image);
  options.extractor.extractor = "simd_orb";
  MatchFilter filter(options);
  filter.setCamera(cameraOf(renderedScene()));
  double stamp = 0;
  const auto process = [&](bool expect_ok) {
    for (const cv::Mat& image : images) {
      const MatchResult& result = filter.process(image, cv::Mat(), stamp += 1 / 30.0);
      EXPECT_TRUE(stamp < 0.05 || result.robust.judgement.pose_found) << options.method << ", stamp " << stamp;
      if (expect_ok) {
        EXPECT_EQ(result.status, Status::kOk) << "stamp " << stamp;
      }
    }
  };
  process(false);
  process(false);
  const long before = g_allocations;
  process(all_ok);
  return g_allocations - before;
}

class PerFrameAllocation : public testing::TestWithParam<std::tuple<int, SearchMode, double>> {};

TEST_P(PerFrameAllocation, IsNoneOnceWarm) {
  MatchFilterOptions options;
  options.extractor.threads = options.matcher_threads = std::get<int>(GetParam());
  options.search = std::get<SearchMode>(GetParam());
  options.robust.rolling_shutter_readout = std::get<double>(GetParam());
  EXPECT_EQ(allocationsOf(options, true), 0);
}

TEST(Allocation, IsNoneByOtherMethodsOnceWarm) {
  // gms_dist_ransac sorts survivors into cells, split2080 copies its two groups (doc/inside/architecture.md).
  const std::set<std::string> allocating = {"gms_dist_ransac", "split2080"};
  for (const MethodEntry& method : methods()) {
    MatchFilterOptions options;
    options.method = method.name;
    EXPECT_EQ(allocationsOf(options, false) > 0, allocating.count(method.name) > 0) << method.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Threads, PerFrameAllocation,
                         testing::Combine(testing::Values(1, 2, 4),
                                          testing::Values(SearchMode::kFull, SearchMode::kGuided),
                                          testing::Values(0, 0.005)));

}  // namespace
}  // namespace gms_ransac
