// Where a sensor was during the last seconds, by the rates of a gyro or by the odometry of wheels.
#pragma once

#include <deque>
#include <string>

#include <Eigen/Geometry>

#include "late_stamps.h"

namespace gms_ransac {

/// X_at_start = motion X_at_end, in the axes of the sensor.
struct TrackMotion {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  double variance = 0;  ///< sum of what the samples in between brought
};

/// Poses at the stamps of the samples, in any frame: the motion between two stamps costs two look-ups.
class MotionTrack {
 public:
  /// `longest_step`: seconds between two samples of one motion, at the most.
  explicit MotionTrack(double longest_step) : longest_step_(longest_step) {}

  static constexpr size_t kMostSamples = 1 << 16;  ///< 30 s at 2 kHz; stamps that creep would keep all

  void clear() { samples_.clear(); }
  bool empty() const { return samples_.empty(); }
  /// Everything up to this time has come.
  bool reaches(double stamp) const { return !empty() && samples_.back().stamp >= stamp; }
  size_t samples() const { return samples_.size(); }
  /// Interpolates. Returns an empty string, or what is missing, as the end of a sentence.
  std::string between(double from, double to, TrackMotion& motion) const;

 protected:
  /// Seconds since the sample before, or 0 for the first; negative: the sample is not newer and to be ignored. One more
  /// than a second older than the newest starts a new stream, and so does the second late one in a row, for the
  /// clock was set back.
  double secondsTo(double stamp);
  /// Adds where the sensor is after a step; `variance` is that of the step.
  void append(double stamp, const Eigen::Isometry3d& step, double variance);

 private:
  struct Sample {
    double stamp;
    Eigen::Isometry3d pose;
    double variance;  ///< sum since the first sample
  };
  /// Index of the first sample later than `stamp`, at least 1 and at most the last; needs two samples.
  size_t after(double stamp) const;
  Sample at(double stamp) const;

  const double longest_step_;
  std::deque<Sample> samples_;
  LateStamps late_;
};

/// The rotation that a gyro measures; its variance is that about each axis, rad^2.
class GyroTrack : public MotionTrack {
 public:
  GyroTrack() : MotionTrack(kLongestStep) {}
  /// `rate` in rad/s; `variance` of each axis, (rad/s)^2, 0: unknown. Returns false, and ignores it, if a number is not
  /// finite or beyond what a sensor measures.
  bool add(double stamp, const Eigen::Vector3d& rate, double variance);

  static constexpr double kLongestStep = 0.1;  ///< 10 Hz, or ten samples of an IMU lost
  static constexpr double kUsualSigma = 0.01;  ///< rad/s, of a sample without covariance: a cheap MEMS gyro

 private:
  Eigen::Vector3d rate_;  ///< of the newest sample
};

struct OdometrySample {
  double stamp = 0;                                        ///< seconds
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< body in the odometry frame
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< of the body in its own axes, m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();       ///< rad/s
  double velocity_variance = 0;                            ///< (m/s)^2; 0: unknown
};

/// The motion by wheels. Its variance is the integral of that of the velocity, m^2/s. Until a pose changes, as in an
/// odometry that fills only its twist, the twist is integrated.
class OdometryTrack : public MotionTrack {
 public:
  OdometryTrack() : MotionTrack(kLongestStep) {}
  /// As GyroTrack::add.
  bool add(const OdometrySample& sample);

  static constexpr double kLongestStep = 0.5;  ///< wheels are read at 10 Hz and more

 private:
  OdometrySample last_;
  bool poses_change_ = false;
};

}  // namespace gms_ransac
