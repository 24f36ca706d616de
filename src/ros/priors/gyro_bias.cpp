#include "priors/gyro_bias.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "priors/turns.h"

namespace gms_ransac {

namespace {

/// Least standard deviation of a visual rotation, radians: what is common to pairs, as the lens, is in no covariance.
constexpr double kVisualFloor = 2e-4;

bool isStill(const StillObservation& observation, const Eigen::Matrix3d& covariance) {
  const double seconds = observation.to - observation.from;
  return observation.visual.norm() < GyroBias::kStillRate * seconds ||
         observation.visual.dot(covariance.inverse() * observation.visual) < kTurnChi2;
}

Eigen::Matrix3d floored(Eigen::Matrix3d covariance) {
  covariance.diagonal().array() += kVisualFloor * kVisualFloor;
  return covariance;
}

}  // namespace

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
