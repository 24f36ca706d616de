#include "priors/gyro_bias.h"

#include <algorithm>

#include <Eigen/LU>

#include "priors/rotation_vectors.h"

namespace gms_ransac {

namespace {

/// Least standard deviation of a visual rotation, radians: what is common to pairs, as the lens, is in no covariance.
constexpr double kVisualFloor = 2e-4;

}  // namespace

void GyroBias::add(const ComparedRotation& seen) {
  const double seconds = seen.to - seen.from;
  if (!(seconds > 0) || !seen.covariance.allFinite()) return;
  Eigen::Matrix3d covariance = seen.covariance;
  covariance.diagonal().array() += kVisualFloor * kVisualFloor;
  const bool still =
      seen.visual.norm() < kStillRate * seconds || seen.visual.dot(covariance.inverse() * seen.visual) < kRotationChi2;
  if (!still) return;
  if (last_from_ != seen.from) before_last_ = with_last_;
  last_from_ = seen.from;

  State& state = with_last_ = before_last_;
  const double since = state.stamp > 0 ? std::max(0.0, seen.to - state.stamp) : 0;
  state.covariance += kDrift * kDrift * since * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d gain =
      state.covariance * (state.covariance + covariance / (seconds * seconds)).inverse().eval();
  state.bias += gain * ((seen.prior - seen.visual) / seconds - state.bias);
  state.covariance = (Eigen::Matrix3d::Identity() - gain) * state.covariance;
  state.covariance = 0.5 * (state.covariance + state.covariance.transpose().eval());
  state.stamp = seen.to;
}

}  // namespace gms_ransac
