// Runs the OpenCV baseline and ours over the same images, interleaved, and times each stage.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "benchmark/benchmark_table.h"
#include "datasets/dataset.h"
#include "gms_ransac/match_filter_options.h"

namespace gms_ransac {

struct BenchmarkOptions {
  int features = 2000;
  /// Threads of OpenCV, our extractor and our matcher. One thread is timed by its processor time, more by the wall
  /// clock.
  int threads = 1;
  int repeat = 3;  ///< times each pair is measured
  int frames = 0;  ///< of the sequence from the first pair on, measured one after the other; fewer than three: none
  std::vector<std::string> methods = {"lo_prosac", "cp_ransac", "gms_ransac"};
  ModelType model = ModelType::kEssential;  ///< of our methods; without intrinsics they use a fundamental matrix

  /// Our pipeline under these options.
  MatchFilterOptions pipeline(const std::string& method, SearchMode search,
                              const std::string& extractor = "simd_orb") const;
};

/// `pair_done` is called after each pair. Throws DatasetError when an image cannot be read, std::invalid_argument for
/// bad options.
BenchmarkTable runBenchmark(const Dataset& dataset, const std::vector<DatasetPair>& pairs,
                            const BenchmarkOptions& options, const std::function<void()>& pair_done);

/// Frames first..first+count-1 one after the other, as a node gets them: OpenCV's chain with its first estimator, and
/// each method on simd_orb. Adds a stage "frame after frame" to the table.
void runFrames(const Dataset& dataset, int first, int count, const BenchmarkOptions& options, BenchmarkTable& table);

/// Extraction from rendered images of these sizes, one after the other, seen through a sharp and a soft lens.
/// `size_done` is called after each size.
BenchmarkTable runSizes(const std::vector<cv::Size>& sizes, const BenchmarkOptions& options,
                        const std::function<void()>& size_done);

}  // namespace gms_ransac
