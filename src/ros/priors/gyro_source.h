// The rotation that the gyro of an IMU measures.
#pragma once

#include <string>

#include <ros/node_handle.h>

#include "parameters.h"
#include "priors/prior_source.h"
#include "priors/sensor_track.h"

namespace gms_ransac {

class GyroSource : public RotationSource {
 public:
  /// Reads the topic `imu` of `nh`.
  GyroSource(const ros::NodeHandle& nh, const Parameters& parameters, TfLookup& tf);

  void start(const std::function<void()>& arrived) override;
  void stop() override { subscriber_.shutdown(); }

 private:
  RotationAnswer measure(const PriorQuery& query) override;
  bool covers(const PriorQuery& query) override { return gyro_.reaches(query.to + 0.5 * query.readout); }
  /// Sets `prior` without rates. Returns what is missing.
  std::string integrate(const PriorQuery& query, RotationPrior& prior) const;

  ros::NodeHandle nh_;
  const std::string imu_frame_;  ///< of the gyro's axes; empty: that of the messages
  SensorTrack<GyroTrack> gyro_;
  ros::Subscriber subscriber_;  ///< last: its callback may run until it is gone
};

}  // namespace gms_ransac
