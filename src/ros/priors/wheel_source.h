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

/// The topic `prior_odom`, shared by the two sources below.
class WheelTrack {
 public:
  WheelTrack(const ros::NodeHandle& nh, TfLookup& tf);

  /// Subscribes, and forgets what came before, unless that was done already.
  void start(const std::function<void()>& arrived);
  void stop() { subscriber_ = ros::Subscriber(); }
  bool reaches(double stamp) const { return wheels_.reaches(stamp); }
  /// Motion of the camera in its own axes.
  std::string between(const PriorQuery& query, TrackMotion& motion) const;

 private:
  ros::NodeHandle nh_;
  SensorTrack<OdometryTrack> wheels_;
  ros::Subscriber subscriber_;  ///< last: its callback may run until it is gone
};

class WheelRotation : public RotationSource {
 public:
  WheelRotation(const Parameters& parameters, std::shared_ptr<WheelTrack> wheels)
      : RotationSource(parameters.image_time_offset), wheels_(std::move(wheels)) {}
  void start(const std::function<void()>& arrived) override { wheels_->start(arrived); }
  void stop() override { wheels_->stop(); }
  bool reaches(const PriorQuery& query) override { return wheels_->reaches(query.to); }

 private:
  RotationAnswer measure(const PriorQuery& query) override;

  const std::shared_ptr<WheelTrack> wheels_;
};

class WheelLength : public LengthSource {
 public:
  explicit WheelLength(std::shared_ptr<WheelTrack> wheels) : wheels_(std::move(wheels)) {}
  void start(const std::function<void()>& arrived) override { wheels_->start(arrived); }
  void stop() override { wheels_->stop(); }
  bool reaches(const PriorQuery& query) override { return wheels_->reaches(query.to); }

 private:
  LengthAnswer measure(const PriorQuery& query, const PairSeen& pair) override;

  const std::shared_ptr<WheelTrack> wheels_;
  WheelCheck check_;
};

}  // namespace gms_ransac
