// Program: single kernels under Google Benchmark, for work on one of them; `benchmark` compares whole stages.
#include <random>

#include <benchmark/benchmark.h>
#include <opencv2/features2d.hpp>

#include "benchmark/dense_motion_statistics.h"
#include "gms_ransac/hamming_matcher.h"
#include "scenes/synthetic_pair.h"

namespace {

using namespace gms_ransac;

DescriptorSet randomDescriptors(int n, uint32_t seed, SimdLevel level) {
  std::mt19937 random(seed);
  cv::Mat rows(n, kDescriptorBytes, CV_8U);
  for (int i = 0; i < n; ++i) {
    for (int b = 0; b < kDescriptorBytes; ++b) rows.at<uint8_t>(i, b) = static_cast<uint8_t>(random());
  }
  DescriptorSet set;
  set.assign(rows);
  set.pack(level);
  return set;
}

/// Items are pairs of descriptors.
void matchBaseline(benchmark::State& state) {
  cv::setNumThreads(1);
  const int n = static_cast<int>(state.range(0));
  const DescriptorSet reference = randomDescriptors(n, 1, SimdLevel::kScalar);
  const DescriptorSet current = randomDescriptors(n, 2, SimdLevel::kScalar);
  std::vector<cv::DMatch> matches;
  for (auto _ : state) cv::BFMatcher(cv::NORM_HAMMING).match(reference.asMat(), current.asMat(), matches);
  state.SetItemsProcessed(state.iterations() * n * n);
}

void match(benchmark::State& state, SimdLevel level, bool mutual, int threads) {
  const int n = static_cast<int>(state.range(0));
  const DescriptorSet reference = randomDescriptors(n, 1, level);
  const DescriptorSet current = randomDescriptors(n, 2, level);
  HammingMatcher matcher({mutual, threads, level});
  std::vector<Match> matches;
  for (auto _ : state) matcher.match(reference, current, matches);
  state.SetItemsProcessed(state.iterations() * n * n);
}

/// Items are descriptors.
void pack(benchmark::State& state, SimdLevel level) {
  const int n = static_cast<int>(state.range(0));
  DescriptorSet set = randomDescriptors(n, 1, level);
  for (auto _ : state) set.pack(level);
  state.SetItemsProcessed(state.iterations() * n);
}

/// Items are matches.
void motionStatistics(benchmark::State& state, bool rotation_and_scale, bool dense) {
  SyntheticPairOptions pair_options;
  pair_options.matches = static_cast<int>(state.range(0));
  static const Scene scene{SceneOptions()};
  const SyntheticPair pair = makeSyntheticPair(scene, 0, 1, pair_options);
  MotionStatisticsOptions options;
  options.rotation = options.scale = rotation_and_scale;
  MotionStatisticsFilter filter(options);
  MotionStatistics statistics;
  for (auto _ : state) {
    if (dense) {
      denseMotionStatistics(options, pair.reference, pair.current, pair.matches, statistics);
    } else {
      filter.compute(pair.reference, pair.current, pair.matches, statistics);
    }
  }
  state.SetItemsProcessed(state.iterations() * pair_options.matches);
}

template <typename... Parameters>
void add(const std::string& name, const std::vector<int64_t>& sizes, Parameters... parameters) {
  auto* family = benchmark::RegisterBenchmark(name.c_str(), parameters...);
  for (int64_t size : sizes) family->Arg(size);
  family->Unit(benchmark::kMicrosecond);
}

void addAll() {
  const std::vector<int64_t> features = {1000, 2000, 5000, 10000};
  add("match/cv::BFMatcher", {1000, 2000}, matchBaseline);
  for (SimdLevel level : {SimdLevel::kAvx512, SimdLevel::kAvx2, SimdLevel::kNeon, SimdLevel::kScalar}) {
    if (!simdLevelSupported(level)) continue;
    add("match/" + toString(level), features, match, level, false, 1);
    add("match/" + toString(level) + "/mutual", features, match, level, true, 1);
    add("match/" + toString(level) + "/mutual/two threads", features, match, level, true, 2);
    add("pack/" + toString(level), {2000}, pack, level);
  }
  for (bool rotation_and_scale : {false, true}) {
    const std::string name = rotation_and_scale ? "GMS rotation + scale/" : "GMS/";
    add(name + "dense", {1000, 3000}, motionStatistics, rotation_and_scale, true);
    add(name + "sparse", {1000, 3000}, motionStatistics, rotation_and_scale, false);
  }
}

}  // namespace

int main(int argc, char** argv) {
  addAll();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
