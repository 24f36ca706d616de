#include "ransac/prosac_sampler.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gms_ransac {

namespace {

/// T_N: after so many draws PROSAC is RANSAC (Chum & Matas 2005, section 2.2).
constexpr double kDrawsToRansac = 200000;

/// Share of all inliers that a prefix must hold to end the search. Not in the paper: a noisy model would end it by
/// fitting the first handful.
constexpr double kSmallestShare = 0.2;

}  // namespace

void ProsacSampler::begin(const SamplingTask& task) {
  task_ = task;
  chance_.setSampleSize(task.sample_size);
  prefix_ = task.sample_size;
  expected_draws_ = kDrawsToRansac;
  for (int i = 0; i < task.sample_size; ++i) {
    expected_draws_ *= static_cast<double>(task.sample_size - i) / (task.matches - i);
  }
  growth_ = 1;
  stop_prefix_ = task.matches;
  drawn_ = 0;
  bound_ = task.max_iterations;
}

void ProsacSampler::grow() {
  const double next = expected_draws_ * (prefix_ + 1) / (prefix_ + 1 - task_.sample_size);
  growth_ += static_cast<int>(std::ceil(next - expected_draws_));
  expected_draws_ = next;
  ++prefix_;
}

bool ProsacSampler::draw(Random& random, int* sample) {
  if (drawn_ >= bound_) return false;
  ++drawn_;
  if (drawn_ > growth_ && prefix_ < stop_prefix_) grow();
  if (growing()) {
    drawDistinct(random, prefix_ - 1, task_.sample_size - 1, sample);
    sample[task_.sample_size - 1] = prefix_ - 1;
  } else {
    drawDistinct(random, prefix_, task_.sample_size, sample);
  }
  return true;
}

void ProsacSampler::newBest(const std::vector<uint8_t>& inlier) {
  // Maximality: the non-random prefix of the largest inlier ratio needs the fewest draws; the longest of equals.
  const int all = std::accumulate(inlier.begin(), inlier.end(), 0);
  double best_ratio = 0;
  int inliers = 0;
  for (int n = 1; n <= task_.matches; ++n) {
    inliers += inlier[static_cast<size_t>(n - 1)];
    if (n <= task_.sample_size || inliers < chance_.minimum(n)) continue;
    if (inliers < kSmallestShare * all) continue;
    const double ratio = static_cast<double>(inliers) / n;
    if (ratio < best_ratio) continue;
    best_ratio = ratio;
    stop_prefix_ = n;
  }
  bound_ = requiredIterations(task_.success_probability, best_ratio, task_.sample_size, task_.max_iterations);
}

}  // namespace gms_ransac
