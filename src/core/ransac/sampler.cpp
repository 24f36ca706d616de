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

}  // namespace gms_ransac
