// Runs the OpenCV baseline and ours over the same images, interleaved, and times each stage.
#pragma once

#include <string>
#include <vector>

#include "datasets/dataset.h"
#include "gms_ransac/match_filter_options.h"
#include "run/series.h"

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
};

/// A record for each measurement: features, threads, stage, what, baseline (what the same stage is compared with, or
/// null), ms, matches or keypoints kept, and how many of them are correct (null where unknown). Set and pairs have to
/// outlive the series.
Series benchmarkSeries(const Dataset& dataset, const std::vector<DatasetPair>& pairs, const BenchmarkOptions& options);

}  // namespace gms_ransac
