#include "robust/fast/stratified_sampler.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

namespace {

constexpr int kFarCells = kSpreadGridSide / 5;
constexpr int kAttempts = 8;

// The first samples come from this share of the matches, and after this many samples all matches take part
// (doc/estimator.md has the measurement).
constexpr double kFirstShare = 0.02;
constexpr double kGrowthSamples = 300;
constexpr int kFirstMultiple = 4;  // of the sample size: the shortest prefix

}  // namespace

void StratifiedSampler::begin(const std::vector<int>& order, const std::vector<int32_t>& cells, int sample_size) {
  order_ = &order;
  cells_ = &cells;
  sample_size_ = sample_size;
  const auto n = static_cast<double>(order.size());
  prefix_ = std::min(n, std::max<double>(kFirstMultiple * sample_size, kFirstShare * n));
  growth_ = std::pow(n / prefix_, 1 / kGrowthSamples);
  drawn_from_ = static_cast<int>(prefix_);
}

bool StratifiedSampler::spread(const int* sample) const {
  int reach = 0;
  for (int i = 0; i < sample_size_; ++i) {
    const int a = (*cells_)[static_cast<size_t>(sample[i])];
    for (int j = 0; j < i; ++j) {
      const int b = (*cells_)[static_cast<size_t>(sample[j])];
      if (a == b) return false;
      reach = std::max({reach, std::abs(a % kSpreadGridSide - b % kSpreadGridSide),
                        std::abs(a / kSpreadGridSide - b / kSpreadGridSide)});
    }
  }
  return reach >= kFarCells;
}

void StratifiedSampler::draw(Random& random, int* sample) {
  const auto n = static_cast<double>(order_->size());
  drawn_from_ = static_cast<int>(prefix_);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    drawDistinct(random, drawn_from_, sample_size_, sample);
    for (int i = 0; i < sample_size_; ++i) sample[i] = (*order_)[static_cast<size_t>(sample[i])];
    if (spread(sample)) break;
  }
  prefix_ = std::min(n, prefix_ * growth_);
}

}  // namespace gms_ransac
