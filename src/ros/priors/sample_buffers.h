// Stamped samples of the last seconds, in order, of a gyro or of wheels, and the motion between two stamps by them.
#pragma once

#include <algorithm>
#include <deque>
#include <string>

#include <Eigen/Geometry>

#include "text.h"

namespace gms_ransac {

/// `Sample` has a `stamp` in seconds.
template <typename Sample>
class SampleBuffer {
 public:
  /// Adds a sample in the order of stamps. Ignores one that is not newer; one more than kRestart older than the newest
  /// starts a new stream and empties the buffer.
  void add(const Sample& sample) {
    if (!samples_.empty() && sample.stamp <= samples_.back().stamp) {
      if (samples_.back().stamp - sample.stamp < kRestart) return;
      samples_.clear();
    }
    samples_.push_back(sample);
    while (samples_.front().stamp < sample.stamp - kSeconds) samples_.pop_front();
  }
  void clear() { samples_.clear(); }
  bool empty() const { return samples_.empty(); }
  /// Everything up to this time has come.
  bool reaches(double stamp) const { return !empty() && samples_.back().stamp >= stamp; }

  static constexpr double kRestart = 1;   ///< seconds
  static constexpr double kSeconds = 30;  ///< kept

 protected:
  /// Index of the first sample later than `stamp`, at least 1 and at most the last. Needs a sample.
  size_t after(double stamp) const {
    const auto later = [](double time, const Sample& sample) { return time < sample.stamp; };
    const auto found = std::upper_bound(samples_.begin(), samples_.end(), stamp, later);
    return std::min(std::max<size_t>(1, static_cast<size_t>(found - samples_.begin())), samples_.size() - 1);
  }
  /// Returns what is missing of the interval, as the end of a sentence; empty: nothing. `longest_step`: seconds between
  /// two samples, at the most.
  std::string missing(double from, double to, double longest_step) const {
    if (samples_.size() < 2) return "no two samples have come";
    if (!reaches(to)) return "the newest sample is " + secondsText(to - samples_.back().stamp) + " too old";
    if (samples_.front().stamp > from)
      return "the samples start " + secondsText(samples_.front().stamp - from) + " later";
    for (size_t i = after(from); i < samples_.size() && samples_[i - 1].stamp < to; ++i) {
      const double step = samples_[i].stamp - samples_[i - 1].stamp;
      if (step > longest_step) return "no sample came for " + secondsText(step) + " between them";
    }
    return std::string();
  }

  std::deque<Sample> samples_;
};

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
};

struct OdometrySample {
  double stamp = 0;                                        ///< seconds
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< body in the odometry frame
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< of the body in its own axes, m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();       ///< rad/s
  double velocity_variance = 0;                            ///< of its largest axis, (m/s)^2; 0: unknown
};

/// X_at_start = motion X_at_end, in the body's frame.
struct OdometryMotion {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  double velocity_variance = 0;  ///< mean over the samples, (m/s)^2; 0: unknown
};

class OdometryBuffer : public SampleBuffer<OdometrySample> {
 public:
  /// As SampleBuffer::add; ignores samples that are not finite.
  void add(const OdometrySample& sample);
  /// Poses interpolated at both times; where no pose ever changes although there is speed, as of an odometry that only
  /// fills its twist, that integrated. Returns an empty string, or what is missing, as the end of a sentence.
  std::string between(double from, double to, OdometryMotion& motion) const;

  static constexpr double kLongestStep = 0.5;  ///< seconds between samples; wheels are read at 10 Hz and more

 private:
  bool posesMove() const;
  /// Interpolated pose at a time within the samples; `after`: the first later sample.
  Eigen::Isometry3d poseAt(size_t after, double stamp) const;
  Eigen::Isometry3d integrateTwist(size_t after, double from, double to) const;
};

}  // namespace gms_ransac
