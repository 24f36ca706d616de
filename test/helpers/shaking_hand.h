// An exact motion of a camera in a hand, and the gyro next to it.
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "priors/motion_track.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

constexpr double kGyroRate = 200, kFrame = 1 / 30.0;

/// A hand that shakes: no axis is like another.
inline Eigen::Vector3d rateOf(double stamp) {
  return {0.8 * std::sin(5.1 * stamp), 0.6 * std::cos(3.3 * stamp + 1), 0.4 * std::sin(7.7 * stamp + 2)};
}

/// The true rotation, integrated a hundred times as finely.
inline Eigen::Matrix3d rotationBetween(double from, double to) {
  constexpr int kSteps = 200;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  const double step = (to - from) / kSteps;
  for (int i = 0; i < kSteps; ++i) R = R * rotationFromVector(step * rateOf(from + (i + 0.5) * step));
  return R;
}

inline GyroTrack gyroOf(double seconds) {
  GyroTrack gyro;
  for (int i = 0; i < seconds * kGyroRate; ++i) gyro.add(i / kGyroRate, rateOf(i / kGyroRate), 1e-6);
  return gyro;
}

}  // namespace gms_ransac
