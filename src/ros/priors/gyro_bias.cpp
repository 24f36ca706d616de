#include "priors/gyro_bias.h"

#include <algorithm>

namespace gms_ransac {

namespace {

/// Least standard deviation of a visual rotation, radians: what is common to pairs, as the lens, is in no covariance.
constexpr double kVisualFloor = 2e-4;

}  // namespace

void GyroBias::add(const ComparedRotation& seen) {
  const double seconds = seen.to - seen.from, squared = seen.visual.squaredNorm();
  const double variance = seen.covariance.trace() / 3 + kVisualFloor * kVisualFloor;
  const bool still = squared < kStillRate * seconds * kStillRate * seconds || squared < kRotationChi2 * variance;
  if (!(seconds > 0) || !still) return;
  if (last_from_ != seen.from) before_last_ = with_last_;
  last_from_ = seen.from;

  State& state = with_last_ = before_last_;
  if (state.stamp > 0) state.variance += kDrift * kDrift * std::max(0.0, seen.to - state.stamp);
  const double gain = state.variance / (state.variance + variance / (seconds * seconds));
  state.bias += gain * ((seen.prior - seen.visual) / seconds - state.bias);
  state.variance *= 1 - gain;
  state.stamp = seen.to;
}

}  // namespace gms_ransac
