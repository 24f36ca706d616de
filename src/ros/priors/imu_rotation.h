// ~rotation_prior imu: rotation of the camera from the rates of a gyro.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include <ros/node_handle.h>
#include <sensor_msgs/Imu.h>

#include "gms_ransac/relative_pose.h"
#include "priors/gyro.h"

namespace gms_ransac {

class TfLookup;

/// Times are seconds of the sensor's clock. May be called from any thread, but start and stop.
class ImuRotation {
 public:
  /// Reads the topic `imu` of `nh`. `imu_frame`: instead of that of the messages; empty: theirs. `arrived` is called
  /// after each message.
  ImuRotation(const ros::NodeHandle& nh, const std::string& imu_frame, std::shared_ptr<TfLookup> tf,
              std::function<void()> arrived);

  /// Subscribes, and forgets what came before.
  void start();
  void stop() { subscriber_.shutdown(); }
  /// Everything up to this time has arrived.
  bool reaches(double stamp);
  /// Rotation of the camera between two times. Returns an empty string, or why it is unknown, as the end of a sentence.
  std::string between(const std::string& camera_frame, double from, double to, RotationPrior& prior);
  /// Learns the bias from the rotation that the images show.
  void learn(const std::string& camera_frame, double from, double to, const RotationPrior& visual);
  /// Summary of what was learnt, for diagnostics.
  std::string learnt();

 private:
  void onImu(const sensor_msgs::ImuConstPtr& imu);
  /// Rotation from the axes of the sensor to those of the camera.
  std::string extrinsics(const std::string& camera_frame, Eigen::Matrix3d& imu_in_camera);

  ros::NodeHandle nh_;
  const std::string given_frame_;
  const std::shared_ptr<TfLookup> tf_;
  const std::function<void()> arrived_;
  ros::Subscriber subscriber_;

  std::mutex mutex_;  ///< guards what follows
  GyroBuffer gyro_;
  GyroBias bias_;
  std::string frame_;     ///< the sensor's
  bool no_gyro_ = false;  ///< the messages are marked as having no rates
};

}  // namespace gms_ransac
