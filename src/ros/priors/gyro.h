// Gyroscope rates of the last seconds: their integral, a rotation, and their bias, learnt while the images show no
// rotation.
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "priors/rotation_comparison.h"
#include "priors/sample_buffer.h"

namespace gms_ransac {

struct GyroSample {
  double stamp = 0;                                ///< seconds
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  ///< rad/s, in the axes of the sensor
  double variance = 0;                             ///< of each axis, (rad/s)^2; 0: unknown
};

/// X_at_start = R X_at_end, both in the axes of the sensor.
struct GyroRotation {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< rad^2, of exp(rotation vector) R; of the samples' noise
  double rate_change = 0;  ///< between its ends, rad/s: what a stamp that is wrong by a second would cost
};

class GyroBuffer : public SampleBuffer<GyroSample> {
 public:
  /// As SampleBuffer::add; ignores samples that are not finite.
  void add(const GyroSample& sample);
  /// Integrates rates minus `bias`, linear between samples. Returns an empty string, or what is missing, as the end of
  /// a sentence.
  std::string integrate(double from, double to, const Eigen::Vector3d& bias, GyroRotation& rotation) const;

  static constexpr double kLongestStep = 0.1;  ///< seconds between samples of one motion, at the most: 10 Hz, or ten
                                               ///< samples of an IMU lost
  static constexpr double kUsualSigma = 0.01;  ///< rad/s, of a sample without covariance: a cheap MEMS gyro

 private:
  Eigen::Vector3d rateAt(size_t after, double stamp) const;
};

/// A Kalman filter on three numbers that drift slowly.
class GyroBias {
 public:
  /// `seen`: in the axes of the gyro, its prior without any bias taken off. Used if the images show no rotation: then
  /// neither extrinsics nor stamps matter. Replaces one with the same start, as while the reference is held.
  void add(const ComparedRotation& seen);

  const Eigen::Vector3d& bias() const { return with_last_.bias; }              ///< rad/s
  const Eigen::Matrix3d& covariance() const { return with_last_.covariance; }  ///< (rad/s)^2
  bool known() const { return last_from_.has_value(); }

  static constexpr double kStillRate = 0.01;  ///< rad/s below which the images show no rotation: half a degree a second
  static constexpr double kFirstSigma = 0.05;  ///< rad/s, before anything is seen: three degrees a second, a cheap MEMS
                                               ///< gyro's zero-rate offset
  static constexpr double kDrift = 1e-4;       ///< rad/s a square root of a second

 private:
  struct State {
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = kFirstSigma * kFirstSigma * Eigen::Matrix3d::Identity();
    double stamp = 0;
  };
  static State updated(State state, const ComparedRotation& seen);

  State before_last_, with_last_;
  std::optional<double> last_from_;  ///< start of the last one that was used
};

}  // namespace gms_ransac
