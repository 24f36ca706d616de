#include "ransac/sampler.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gms_ransac {

int countPrefix(const std::vector<uint8_t>& inlier, int prefix) {
  return std::accumulate(inlier.begin(), inlier.begin() + prefix, 0);
}

int prefixLength(double fraction, int n, int least) {
  const int length = static_cast<int>(std::ceil(fraction * n - 1e-9));
  return std::min(n, std::max(least, length));
}

void UniformSampler::begin(const SamplingTask& task) {
  task_ = task;
  prefix_ = prefixLength(options_.fraction, task.matches, task.sample_size);
  drawn_ = 0;
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
double logBinomialCoefficient(int n, int k) {
  constexpr double kLarge = 1e250;  // times the largest factor it is still a number
  double product = 1, logarithm = 0;
  for (int i = 1; i <= k; ++i) {
    product *= static_cast<double>(n - k + i) / i;
    if (product < kLarge) continue;
    logarithm += std::log(product);
    product = 1;
  }
  return logarithm + std::log(product);
}

double binomialTail(int n, int k) {
  const double log_term =
      logBinomialCoefficient(n, k) + k * std::log(kChanceOfFit) + (n - k) * std::log1p(-kChanceOfFit);
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

void ChanceSupport::setSampleSize(int sample_size) {
  if (sample_size == sample_size_) return;
  sample_size_ = sample_size;
  minimum_.clear();
}

int ChanceSupport::minimum(int n) {
  if (n < sample_size_) return n + 1;
  const auto others = static_cast<size_t>(n - sample_size_);
  if (others >= minimum_.size()) minimum_.resize(others + 1, 0);
  if (minimum_[others] == 0) minimum_[others] = sample_size_ + smallestUnlikely(n - sample_size_);
  return minimum_[others];
}

}  // namespace gms_ransac
