// Rotation and length by the odometry of wheels, whose slip the images show.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include <ros/node_handle.h>

#include "parameters.h"
#include "priors/prior_source.h"
#include "priors/sensor_track.h"
#include "priors/wheel_check.h"

namespace gms_ransac {

class WheelRotation : public RotationSource {
 public:
  /// Reads the topic `prior_odom` of `nh`.
  WheelRotation(const ros::NodeHandle& nh, const Parameters& parameters, TfLookup& tf);

  /// Unless that was done already.
  void start(const std::function<void()>& arrived) override;
  void stop() override { subscriber_ = ros::Subscriber(); }
  /// Motion of the camera in its own axes. `query`: on the sensor's clock.
  std::string between(const PriorQuery& query, TrackMotion& motion) const;

 private:
  RotationAnswer measure(const PriorQuery& query) override;
  bool covers(const PriorQuery& query) override { return wheels_.reaches(query.to); }

  ros::NodeHandle nh_;
  SensorTrack<OdometryTrack> wheels_;
  ros::Subscriber subscriber_;  ///< last: its callback may run until it is gone
};

class WheelLength : public LengthSource {
 public:
  /// `learns`: compares their rotation with the images, which nobody else does.
  WheelLength(std::shared_ptr<WheelRotation> wheels, bool learns) : wheels_(std::move(wheels)), learns_(learns) {}
  void start(const std::function<void()>& arrived) override { wheels_->start(arrived); }
  void stop() override { wheels_->stop(); }
  bool reaches(const PriorQuery& query) override { return wheels_->reaches(query); }
  PriorReport report() override;

 private:
  LengthAnswer measure(const PriorQuery& query, const PairSeen& pair) override;

  const std::shared_ptr<WheelRotation> wheels_;
  const bool learns_;
  WheelCheck check_;
};

}  // namespace gms_ransac
