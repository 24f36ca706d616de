#include "priors/gyro.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "priors/rotation_vectors.h"

namespace gms_ransac {

namespace {

double sigma(const GyroSample& sample) {
  return sample.variance > 0 ? std::sqrt(sample.variance) : GyroBuffer::kUsualSigma;
}

/// Least standard deviation of a visual rotation, radians: what is common to pairs, as the lens, is in no covariance.
constexpr double kVisualFloor = 2e-4;

bool isStill(const ComparedRotation& seen, const Eigen::Matrix3d& covariance) {
  return seen.visual.norm() < GyroBias::kStillRate * (seen.to - seen.from) ||
         seen.visual.dot(covariance.inverse() * seen.visual) < kRotationChi2;
}

Eigen::Matrix3d floored(Eigen::Matrix3d covariance) {
  covariance.diagonal().array() += kVisualFloor * kVisualFloor;
  return covariance;
}

}  // namespace

void GyroBuffer::add(const GyroSample& sample) {
  if (std::isfinite(sample.stamp) && sample.rate.allFinite()) SampleBuffer::add(sample);
}

Eigen::Vector3d GyroBuffer::rateAt(size_t after, double stamp) const {
  const GyroSample &a = samples_[after - 1], &b = samples_[after];
  return a.rate + (stamp - a.stamp) / (b.stamp - a.stamp) * (b.rate - a.rate);
}

std::string GyroBuffer::integrate(double from, double to, const Eigen::Vector3d& bias, GyroRotation& rotation) const {
  if (samples_.empty()) return "no sample has come";
  std::string problem = missing(from, to);
  if (!problem.empty()) return problem;
  rotation = GyroRotation();
  size_t after = this->after(from);
  if (after == 0) return "only one sample has come";
  const Eigen::Vector3d first_rate = rateAt(after, from);
  Eigen::Vector3d rate = first_rate;
  double variance = 0;
  for (double stamp = from; stamp < to; ++after) {
    const double step = samples_[after].stamp - samples_[after - 1].stamp;
    if (step > kLongestStep) return missingStep(step);
    const double end = std::min(to, samples_[after].stamp);
    const Eigen::Vector3d end_rate = rateAt(after, end);
    rotation.R = rotation.R * rotationBy((end - stamp) * (0.5 * (rate + end_rate) - bias));
    // A sample stands for one step, of which this may be a part.
    variance += (end - stamp) * step * sigma(samples_[after]) * sigma(samples_[after]);
    stamp = end;
    rate = end_rate;
  }
  rotation.covariance.diagonal().setConstant(variance);
  rotation.rate_change = (rate - first_rate).norm();
  return std::string();
}

GyroBias::State GyroBias::updated(State state, const ComparedRotation& seen) {
  const double seconds = seen.to - seen.from;
  const double since = state.stamp > 0 ? std::max(0.0, seen.to - state.stamp) : 0;
  state.covariance += kDrift * kDrift * since * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d noise = floored(seen.covariance) / (seconds * seconds);
  const Eigen::Matrix3d gain = state.covariance * (state.covariance + noise).inverse();
  state.bias += gain * ((seen.prior - seen.visual) / seconds - state.bias);
  state.covariance = (Eigen::Matrix3d::Identity() - gain) * state.covariance;
  state.covariance = 0.5 * (state.covariance + state.covariance.transpose().eval());
  state.stamp = seen.to;
  return state;
}

void GyroBias::add(const ComparedRotation& seen) {
  if (!(seen.to > seen.from) || !seen.covariance.allFinite()) return;
  if (!isStill(seen, floored(seen.covariance))) return;
  if (last_from_ != seen.from) before_last_ = with_last_;
  last_from_ = seen.from;
  with_last_ = updated(before_last_, seen);
}

}  // namespace gms_ransac
