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

bool isStill(const StillObservation& observation, const Eigen::Matrix3d& covariance) {
  const double seconds = observation.to - observation.from;
  return observation.visual.norm() < GyroBias::kStillRate * seconds ||
         observation.visual.dot(covariance.inverse() * observation.visual) < kRotationChi2;
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

void GyroBias::reset() {
  settled_.bias.setZero();
  settled_.covariance = kFirstSigma * kFirstSigma * Eigen::Matrix3d::Identity();
  settled_.stamp = 0;
  with_pending_ = settled_;
  pending_.reset();
  observations_ = 0;
}

GyroBias::State GyroBias::updated(State state, const StillObservation& observation) {
  const double seconds = observation.to - observation.from;
  const double since = state.stamp > 0 ? std::max(0.0, observation.to - state.stamp) : 0;
  state.covariance += kDrift * kDrift * since * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d noise = floored(observation.covariance) / (seconds * seconds);
  const Eigen::Matrix3d gain = state.covariance * (state.covariance + noise).inverse();
  state.bias += gain * ((observation.gyro - observation.visual) / seconds - state.bias);
  state.covariance = (Eigen::Matrix3d::Identity() - gain) * state.covariance;
  state.covariance = 0.5 * (state.covariance + state.covariance.transpose().eval());
  state.stamp = observation.to;
  return state;
}

void GyroBias::add(const StillObservation& observation) {
  if (!(observation.to > observation.from) || !observation.covariance.allFinite()) return;
  if (!isStill(observation, floored(observation.covariance))) return;
  if (pending_ && pending_->from != observation.from) {
    settled_ = with_pending_;
    pending_.reset();
  }
  observations_ += pending_ ? 0 : 1;
  pending_ = observation;
  with_pending_ = updated(settled_, observation);
}

}  // namespace gms_ransac
