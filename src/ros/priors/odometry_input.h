// `prior_odom` as the camera's motion: what ~rotation_prior odom and ~scale odometry ask.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>

#include "priors/odometry_buffer.h"
#include "tf_lookup.h"

namespace gms_ransac {

class OdometryInput {
 public:
  /// `arrived` is called after each message.
  OdometryInput(const ros::NodeHandle& nh, std::shared_ptr<TfLookup> tf, std::function<void()> arrived);

  void start();
  void stop();
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
