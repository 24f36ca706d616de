#include "priors/gyro_buffer.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "priors/turns.h"

namespace gms_ransac {

namespace {

double sigma(const GyroSample& sample) {
  return sample.variance > 0 ? std::sqrt(sample.variance) : GyroBuffer::kUsualSigma;
}

}  // namespace

void GyroBuffer::add(const GyroSample& sample) {
  if (std::isfinite(sample.stamp) && sample.rate.allFinite()) SampleBuffer::add(sample);
}

Eigen::Vector3d GyroBuffer::rateAt(size_t after, double stamp) const {
  const GyroSample &a = samples_[after - 1], &b = samples_[after];
  return a.rate + (stamp - a.stamp) / (b.stamp - a.stamp) * (b.rate - a.rate);
}

std::string GyroBuffer::integrate(double from, double to, const Eigen::Vector3d& bias, GyroTurn& turn) const {
  if (samples_.empty()) return "no sample has come";
  std::string problem = missing(from, to);
  if (!problem.empty()) return problem;
  turn = GyroTurn();
  const auto first = std::upper_bound(samples_.begin(), samples_.end(), from,
                                      [](double stamp, const GyroSample& sample) { return stamp < sample.stamp; });
  auto after = std::max<size_t>(1, static_cast<size_t>(first - samples_.begin()));
  after = std::min(after, samples_.size() - 1);
  if (after == 0) return "only one sample has come";
  const Eigen::Vector3d first_rate = rateAt(after, from);
  Eigen::Vector3d rate = first_rate;
  double variance = 0;
  for (double stamp = from; stamp < to; ++after) {
    const double step = samples_[after].stamp - samples_[after - 1].stamp;
    if (step > kLongestStep) return missingStep(step);
    const double end = std::min(to, samples_[after].stamp);
    const Eigen::Vector3d end_rate = rateAt(after, end);
    turn.R = turn.R * turnOf((end - stamp) * (0.5 * (rate + end_rate) - bias));
    // A sample stands for one step, of which this may be a part.
    variance += (end - stamp) * step * sigma(samples_[after]) * sigma(samples_[after]);
    stamp = end;
    rate = end_rate;
  }
  turn.covariance.diagonal().setConstant(variance);
  turn.rate_change = (rate - first_rate).norm();
  return std::string();
}

}  // namespace gms_ransac
