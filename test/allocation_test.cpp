// The per-frame path of the core allocates nothing once it has seen a frame of each kind. Counts operator new; pixel
// buffers of OpenCV have an allocator of their own and are not counted.
#include <atomic>
#include <cstdlib>
#include <new>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "gms_ransac/match_filter.h"
#include "scenes/scene.h"

namespace {
std::atomic<long> g_allocations{0};  // OpenCV's threads allocate as well

void* countedAllocation(size_t size, size_t alignment) {
  g_allocations.fetch_add(1, std::memory_order_relaxed);
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size) != 0) throw std::bad_alloc();
  return memory;
}
}  // namespace

// Not inlined, or the compiler takes new and delete for a mismatched pair.
[[gnu::noinline]] void* operator new(size_t size) { return countedAllocation(size, alignof(std::max_align_t)); }
[[gnu::noinline]] void* operator new(size_t size, std::align_val_t alignment) {
  return countedAllocation(size, static_cast<size_t>(alignment));
}
// AddressSanitizer's would not call ours, and what it hands out must not reach std::free; std::stable_sort asks for it.
[[gnu::noinline]] void* operator new(size_t size, const std::nothrow_t&) noexcept {
  try {
    return operator new(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t, std::align_val_t) noexcept { std::free(memory); }

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
  constexpr int kFrames = 4;
  const Scene scene{SceneOptions()};
  std::vector<cv::Mat> images;
  for (int i = 0; i < kFrames; ++i) images.push_back(scene.render(i).image);

  MatchFilterOptions options;
  options.method = "lo_prosac";
  options.extractor.extractor = "simd_orb";
  options.extractor.threads = options.matcher_threads = std::get<int>(GetParam());
  options.search = std::get<SearchMode>(GetParam());
  options.robust.rolling_shutter_readout = std::get<double>(GetParam());
  MatchFilter filter(options);
  filter.setCamera(Camera(scene.intrinsics(), images[0].size()));
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
