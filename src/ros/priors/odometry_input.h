// `prior_odom` as the motion of the camera, for ~rotation_prior odom and ~scale odometry.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <Eigen/Geometry>

#include "priors/sample_buffer.h"

namespace gms_ransac {

class TfLookup;

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

class OdometryInput {
 public:
  /// `arrived` is called after each message.
  OdometryInput(const ros::NodeHandle& nh, std::shared_ptr<TfLookup> tf, std::function<void()> arrived);

  void start();
  void stop() { subscriber_.shutdown(); }
  bool reaches(double stamp);
  /// The camera's motion: X_at_start = motion X_at_end, in its optical frame. Returns an empty string, or why there is
  /// none, as the end of a sentence.
  std::string between(const std::string& camera_frame, double from, double to, OdometryMotion& motion);

 private:
  void onOdometry(const nav_msgs::OdometryConstPtr& odometry);

  ros::NodeHandle nh_;
  const std::shared_ptr<TfLookup> tf_;
  const std::function<void()> arrived_;
  ros::Subscriber subscriber_;

  std::mutex mutex_;  ///< guards what follows
  OdometryBuffer samples_;
  std::string body_frame_;
};

}  // namespace gms_ransac
