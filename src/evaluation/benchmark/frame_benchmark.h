// The benchmark of what depends on the image before: whole frames of a sequence, and extraction at several image sizes.
#pragma once

#include <functional>
#include <vector>

#include <opencv2/core/types.hpp>

#include "benchmark/benchmark_suite.h"

namespace gms_ransac {

/// Frames first..first+count-1 one after the other, as a node gets them: OpenCV's chain with its first estimator, and
/// each method on simd_orb. Adds a stage "frame after frame" to the table.
void runFrames(const Dataset& dataset, int first, int count, const BenchmarkOptions& options, BenchmarkTable& table);

/// Extraction from rendered images of these sizes, one after the other, seen through a sharp and a soft lens.
/// `size_done` is called after each size.
BenchmarkTable runSizes(const std::vector<cv::Size>& sizes, const BenchmarkOptions& options,
                        const std::function<void()>& size_done);

}  // namespace gms_ransac
