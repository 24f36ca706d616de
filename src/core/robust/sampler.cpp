#include "robust/sampler.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "robust/prosac_sampler.h"

namespace gms_ransac {

namespace {

/// A rest below this share of the matches is not worth a group of its own.
constexpr double kSmallestRest = 0.05;

int countPrefix(const std::vector<uint8_t>& inlier, int prefix) {
  return std::accumulate(inlier.begin(), inlier.begin() + prefix, 0);
}

}  // namespace

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

void UniformSampler::improve(const std::vector<uint8_t>& inlier) {
  const double ratio = static_cast<double>(countPrefix(inlier, prefix_)) / prefix_;
  const bool reached = options_.target_ratio > 0 && ratio >= options_.target_ratio;
  const int exponent = task_.sample_size + options_.extra_tests;
  bound_ = reached ? 0 : requiredIterations(task_.confidence, ratio, exponent, task_.max_iterations);
}

void ConfidenceGroupSampler::begin(const SamplingTask& task) {
  task_ = task;
  groups_.clear();
  double covered = ratio_;
  while (covered < 1 - kSmallestRest) {
    groups_.push_back({prefixLength(covered, task.matches, task.sample_size), task.max_iterations});
    covered = geometric_ ? covered + ratio_ * (1 - covered) : 1;
  }
  groups_.push_back({task.matches, task.max_iterations});
  chance_.setSampleSize(task.sample_size);
  phase_ = 0;
  drawn_ = drawn_in_phase_ = 0;
  supported_ = false;
}

bool ConfidenceGroupSampler::phaseFailed() const {
  if (phase_ + 1 == groups_.size()) return false;
  const int drawn_before = drawn_ - drawn_in_phase_;
  const int budget = (task_.max_iterations - drawn_before) / 2;
  return drawn_in_phase_ >= budget || groups_[phase_].bound > groups_[phase_ + 1].bound;
}

bool ConfidenceGroupSampler::draw(Random& random, int* sample) {
  if (drawn_ >= task_.max_iterations) return false;
  if (supported_ && drawn_in_phase_ >= groups_[phase_].bound) return false;
  while (phaseFailed()) {
    ++phase_;
    drawn_in_phase_ = 0;
  }
  ++drawn_;
  ++drawn_in_phase_;
  drawDistinct(random, groups_[phase_].size, task_.sample_size, sample);
  return true;
}

void ConfidenceGroupSampler::improve(const std::vector<uint8_t>& inlier) {
  int inliers = 0;
  for (Group& group : groups_) {
    inliers = countPrefix(inlier, group.size);
    const double ratio = static_cast<double>(inliers) / group.size;
    group.bound = requiredIterations(task_.confidence, ratio, task_.sample_size, task_.max_iterations);
  }
  supported_ = inliers >= chance_.minimum(task_.matches);
}

std::unique_ptr<Sampler> makeSampler(const Method& method, const RobustOptions& options) {
  UniformSampler::Options uniform;
  uniform.target_ratio = options.target_ratio;
  switch (method.sampler) {
    case SamplerChoice::kConfidenceGroups:
      return std::make_unique<ConfidenceGroupSampler>(options.ratio, options.geometric_groups);
    case SamplerChoice::kProsac:
      return std::make_unique<ProsacSampler>();
    case SamplerChoice::kSplit:
      uniform.fraction = options.split;
      break;
    default:
      break;
  }
  if (method.verifier == VerifierChoice::kTdd) uniform.extra_tests = options.tdd_d;
  return std::make_unique<UniformSampler>(uniform);
}

}  // namespace gms_ransac
