#include "ransac/sampler.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "gms_ransac/point_pairs.h"

namespace gms_ransac {

int countPrefix(const std::vector<uint8_t>& inlier, int prefix) {
  return std::accumulate(inlier.begin(), inlier.begin() + prefix, 0);
}

int prefixLength(double fraction, int n, int least) {
  const int length = static_cast<int>(std::ceil(fraction * n - 1e-9));
  return std::min(n, std::max(least, length));
}

void UniformSampler::begin(const SamplingTask& task, int drawn) {
  task_ = task;
  prefix_ = prefixLength(options_.fraction, task.matches, task.sample_size);
  drawn_ = drawn;
  bound_ = task.max_iterations;
}

bool UniformSampler::draw(Random& random, int* sample) {
  if (drawn_ >= bound_) return false;
  ++drawn_;
  drawDistinct(random, prefix_, task_.sample_size, sample);
  return true;
}

void UniformSampler::newBest(const std::vector<uint8_t>& inlier) {
  const double ratio = static_cast<double>(countPrefix(inlier, prefix_)) / prefix_;
  const bool reached = options_.target_inlier_ratio && ratio >= *options_.target_inlier_ratio;
  const int exponent = task_.sample_size + options_.extra_tests;
  bound_ = reached ? 0 : requiredIterations(task_.success_probability, ratio, exponent, task_.max_iterations);
}

namespace {

constexpr double kChanceOfFit = 0.05;        ///< beta of Chum & Matas 2005
constexpr double kChanceOfAccepting = 0.05;  ///< psi of Chum & Matas 2005

/// Not by std::lgamma, which writes to a variable of the process.
double logFactorial(int n) {
  int sign;
  return lgamma_r(n + 1.0, &sign);
}

double binomialTail(int n, int k) {
  const double log_term = logFactorial(n) - logFactorial(k) - logFactorial(n - k) + k * std::log(kChanceOfFit) +
                          (n - k) * std::log1p(-kChanceOfFit);
  double term = std::exp(log_term), sum = 0;
  for (int i = k; i <= n && term > 1e-12; ++i) {
    sum += term;
    term *= (n - i) * kChanceOfFit / ((i + 1) * (1 - kChanceOfFit));
  }
  return sum;
}

/// Smallest k with a tail below kChanceOfAccepting, looked for from where a normal distribution has it.
int smallestUnlikely(int n) {
  constexpr double kDeviations = 1.645;
  int k = static_cast<int>(n * kChanceOfFit + kDeviations * std::sqrt(n * kChanceOfFit * (1 - kChanceOfFit)));
  k = std::min(k, n);
  while (k <= n && binomialTail(n, k) >= kChanceOfAccepting) ++k;
  while (k > 0 && binomialTail(n, k - 1) < kChanceOfAccepting) --k;
  return k;
}

}  // namespace

int requiredIterations(double success_probability, double inlier_ratio, int exponent, int cap) {
  const double good_sample = std::pow(std::min(1.0, std::max(0.0, inlier_ratio)), exponent);
  if (good_sample >= 1) return 1;
  const double draws = std::log1p(-success_probability) / std::log1p(-good_sample);
  return draws < cap ? std::max(1, static_cast<int>(std::ceil(draws))) : cap;
}

int ChanceSupport::minimum(int sample_size, int n) {
  if (n < sample_size) return n + 1;
  const auto others = static_cast<size_t>(n - sample_size);
  if (others >= minimum_.size()) minimum_.resize(others + 1, 0);
  if (minimum_[others] == 0) minimum_[others] = smallestUnlikely(n - sample_size);
  return sample_size + minimum_[others];
}

namespace {

/// T_N: after so many draws PROSAC is RANSAC (Chum & Matas 2005, section 2.2).
constexpr double kDrawsToRansac = 200000;

/// Share of all inliers that a prefix must hold to end the search. Not in the paper: a noisy model would end it by
/// fitting the first handful.
constexpr double kSmallestShare = 0.2;

}  // namespace

void ProsacSampler::begin(const SamplingTask& task) {
  task_ = task;
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
    if (n <= task_.sample_size || inliers < chance_.minimum(task_.sample_size, n)) continue;
    if (inliers < kSmallestShare * all) continue;
    const double ratio = static_cast<double>(inliers) / n;
    if (ratio < best_ratio) continue;
    best_ratio = ratio;
    stop_prefix_ = n;
  }
  bound_ = requiredIterations(task_.success_probability, best_ratio, task_.sample_size, task_.max_iterations);
}

namespace {

constexpr int kFarCells = kSpreadGridSide / 5;
constexpr int kAttempts = 8;

/// One clean sample is not enough: its model may start the local optimisation near the wrong minimum.
constexpr int kMinimumSamples = 8;

constexpr double kGrowthSamples = 300;  ///< after which all matches take part (doc/measured/constants.md)
constexpr int kFirstMultiple = 4;       // of the sample size: the shortest prefix

}  // namespace

void StratifiedSampler::begin(const SamplingTask& task, const std::vector<int>& order,
                              const std::vector<int32_t>& cells, double first_share) {
  task_ = task;
  cells_.resize(order.size());
  for (size_t rank = 0; rank < order.size(); ++rank) cells_[rank] = cells[static_cast<size_t>(order[rank])];
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
  const bool by_rank_alone = drawn_ > kMinimumSamples && drawn_ % 2 == 0;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    drawDistinct(random, drawn_from_, task_.sample_size, sample);
    if (by_rank_alone || spread(sample)) break;
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
