#include "ransac/stratified_sampler.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "gms_ransac/point_pairs.h"

namespace gms_ransac {

namespace {

constexpr int kFarCells = kSpreadGridSide / 5;
constexpr int kAttempts = 8;

/// One clean sample is not enough: its model may start the local optimisation near the wrong minimum.
constexpr int kMinimumSamples = 8;

constexpr double kGrowthSamples = 300;  ///< after which all matches take part (doc/estimator.md)
constexpr int kFirstMultiple = 4;       // of the sample size: the shortest prefix

}  // namespace

void StratifiedSampler::begin(const SamplingTask& task, const std::vector<int>& order,
                              const std::vector<int32_t>& cells, double first_share) {
  task_ = task;
  cells_.resize(order.size());
  for (size_t k = 0; k < order.size(); ++k) cells_[k] = cells[static_cast<size_t>(order[k])];
  const auto n = static_cast<double>(task.matches);
  prefix_ = std::min(n, std::max<double>(kFirstMultiple * task.sample_size, first_share * n));
  growth_ = std::pow(n / prefix_, 1 / kGrowthSamples);
  drawn_from_ = static_cast<int>(prefix_);
  bound_prefix_ = drawn_ = 0;
  required_ = task.max_iterations;
  inlier_.clear();
}

bool StratifiedSampler::spread(const int* sample) const {
  int reach = 0;
  for (int i = 0; i < task_.sample_size; ++i) {
    const int a = cells_[static_cast<size_t>(sample[i])];
    for (int j = 0; j < i; ++j) {
      const int b = cells_[static_cast<size_t>(sample[j])];
      if (a == b) return false;
      reach = std::max({reach, std::abs(a % kSpreadGridSide - b % kSpreadGridSide),
                        std::abs(a / kSpreadGridSide - b / kSpreadGridSide)});
    }
  }
  return reach >= kFarCells;
}

bool StratifiedSampler::draw(Random& random, int* sample) {
  if (!inlier_.empty() && drawn_from_ != bound_prefix_) updateBound();
  if (drawn_ >= task_.max_iterations || drawn_ >= std::max(required_, kMinimumSamples)) return false;
  ++drawn_;
  drawn_from_ = static_cast<int>(prefix_);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    drawDistinct(random, drawn_from_, task_.sample_size, sample);
    if (spread(sample)) break;
  }
  prefix_ = std::min(static_cast<double>(task_.matches), prefix_ * growth_);
  return true;
}

void StratifiedSampler::newBest(const std::vector<uint8_t>& inlier) {
  inlier_ = inlier;
  bound_prefix_ = 0;
}

void StratifiedSampler::updateBound() {
  bound_prefix_ = drawn_from_;
  const double ratio = static_cast<double>(countPrefix(inlier_, bound_prefix_)) / std::max(1, bound_prefix_);
  required_ = requiredIterations(task_.success_probability, ratio, task_.sample_size, task_.max_iterations);
}

}  // namespace gms_ransac
