// Poses and velocities of another odometry, and the motion between two times. Knows no topic.
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "priors/sample_buffer.h"

namespace gms_ransac {

struct OdometrySample {
  double stamp = 0;                                        ///< seconds
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< body in the odometry frame
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< of the body in its own axes, m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();       ///< rad/s
  double velocity_variance = 0;                            ///< of its largest axis, (m/s)^2; 0: not told
};

/// X_at_start = motion X_at_end, in the body's frame.
struct OdometryMotion {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  double velocity_variance = 0;  ///< mean over the samples, (m/s)^2; 0: not told
};

class OdometryBuffer : public SampleBuffer<OdometrySample> {
 public:
  /// As SampleBuffer::add; one that is not finite is left out.
  void add(const OdometrySample& sample);
  /// Poses interpolated at both times; where no pose ever changes although there is speed, as of an odometry that only
  /// fills its twist, that integrated. Returns an empty string, or what is missing, as the end of a sentence.
  std::string between(double from, double to, OdometryMotion& motion) const;

  static constexpr double kLongestStep = 0.5;  ///< seconds between samples; wheels are read at 10 Hz and more

 private:
  bool posesMove() const;
  /// Of the pose at a time within the samples; `after`: the first sample that is later.
  Eigen::Isometry3d poseAt(size_t after, double stamp) const;
  Eigen::Isometry3d integrateTwist(size_t after, double from, double to) const;
};

}  // namespace gms_ransac
