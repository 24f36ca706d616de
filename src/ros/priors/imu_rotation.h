// ~rotation_prior imu: rotation of the camera from the rates of a gyro.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include <ros/node_handle.h>
#include <sensor_msgs/Imu.h>

#include "priors/gyro.h"
#include "priors/rotation_source.h"

namespace gms_ransac {

class ImuRotation : public RotationSource {
 public:
  /// Reads the topic `imu` of `nh`. `imu_frame`: instead of that of the messages; empty: theirs. `arrived` is called
  /// after each message.
  ImuRotation(const ros::NodeHandle& nh, const std::string& imu_frame, std::shared_ptr<TfLookup> tf,
              std::function<void()> arrived);

  void start() override;
  void stop() override;
  bool reaches(const std::string& camera_frame, double stamp) override;
  std::string between(const std::string& camera_frame, double from, double to, RotationPrior& prior) override;
  bool tellsRates() const override { return true; }
  void learn(const std::string& camera_frame, double from, double to, const RotationPrior& visual) override;
  std::string learnt() override;

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
