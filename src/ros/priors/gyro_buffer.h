// Gyro rates of the last seconds, and the turn between two times that they add up to. Knows no topic.
#pragma once

#include <string>

#include <Eigen/Core>

#include "priors/sample_buffer.h"

namespace gms_ransac {

struct GyroSample {
  double stamp = 0;                                ///< seconds
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  ///< rad/s, in the axes of the sensor
  double variance = 0;                             ///< of each axis, (rad/s)^2; 0: not told
};

/// X_at_start = R X_at_end, both in the axes of the sensor.
struct GyroTurn {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< rad^2, of exp(rotation vector) R; of the samples' noise
  double rate_change = 0;  ///< between its ends, rad/s: what a stamp that is wrong by a second would cost
};

class GyroBuffer : public SampleBuffer<GyroSample> {
 public:
  /// As SampleBuffer::add; one that is not finite is left out.
  void add(const GyroSample& sample);
  /// Integrates rates less `bias`, linear between samples. Returns an empty string, or what is missing, as the end of
  /// a sentence that begins with what is asked for.
  std::string integrate(double from, double to, const Eigen::Vector3d& bias, GyroTurn& turn) const;

  static constexpr double kLongestStep = 0.1;  ///< seconds between samples that are one motion; a tenth of a turn a
                                               ///< second at 10 Hz, and ten times what an IMU leaves out
  static constexpr double kUsualSigma = 0.01;  ///< rad/s, of a sample where nothing is told; a cheap MEMS gyro's

 private:
  Eigen::Vector3d rateAt(size_t after, double stamp) const;
};

}  // namespace gms_ransac
