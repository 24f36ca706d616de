// The rotation that the gyro of an IMU measures, less its bias, which is learnt while the images show no rotation.
#pragma once

#include <atomic>
#include <mutex>
#include <string>

#include <ros/node_handle.h>

#include "priors/gyro_bias.h"
#include "priors/prior_source.h"
#include "priors/sensor_track.h"

namespace gms_ransac {

class GyroSource : public RotationSource {
 public:
  /// Reads the topic `imu` of `nh`. `imu_frame`: of the gyro's axes; empty: that of the messages.
  GyroSource(const ros::NodeHandle& nh, const std::string& imu_frame, TfLookup& tf);

  /// RobustOptions::rolling_shutter_readout: interval around each image for which the gyro is integrated.
  void setReadout(double seconds) { readout_ = seconds; }

  void start(const std::function<void()>& arrived) override;
  void stop() override { subscriber_.shutdown(); }
  bool reaches(const std::string& camera_frame, double stamp) override;
  std::string ask(const PriorQuery& query, RotationPrior& prior) override;
  std::string askRates(const PriorQuery& query, RotationPrior& prior) override;
  void compare(const PriorQuery& query, const RotationPrior& visual) override;
  void report(PriorReport& report) override;

 private:
  GyroBias bias() const;

  ros::NodeHandle nh_;
  const std::string imu_frame_;
  std::atomic<double> readout_{0};
  SensorTrack<GyroTrack> gyro_;
  mutable std::mutex mutex_;  ///< guards the next
  GyroBias bias_;
  ros::Subscriber subscriber_;  ///< last: its callback may run until it is gone
};

}  // namespace gms_ransac
