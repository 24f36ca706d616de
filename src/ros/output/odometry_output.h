// Publishes the integrated motion: ~odom, ~twist, ~pose, ~transform, ~path and, if wanted, on tf.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/node_handle.h>

#include "stream/processed_frame.h"
#include "throttle.h"

namespace gms_ransac {

class TfLookup;
class WatchedBroadcaster;

class OdometryOutput {
 public:
  OdometryOutput(const ros::NodeHandle& nh, ros::NodeHandle& outputs, const Parameters& parameters,
                 WatchedBroadcaster& broadcaster, const ros::SubscriberStatusCallback& listeners_changed);
  ~OdometryOutput();

  int listeners() const;
  /// Why ~odom could not be published, and the remedy; empty: no problem. From the thread of `publish`.
  const std::string& problem() const { return problem_; }
  /// The last pose given on ~set_pose since the last call, as that of the camera of this image. None: nothing was
  /// given, or tf does not know the camera in ~base_frame yet.
  std::optional<OdometryEstimate> popSetPose(const std_msgs::Header& camera);
  /// Publishes the place of the camera at an image, if it is known.
  void publish(const ProcessedFrame& processed, bool broadcast);

 private:
  void onSetPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  /// Pose of the camera in ~base_frame at the image's stamp; identity without ~base_frame. None, with a throttled
  /// warning, while tf does not know it.
  std::optional<Eigen::Isometry3d> cameraInBase(const std_msgs::Header& camera);
  void publishPath(const nav_msgs::Odometry& odom);
  void broadcast(const Eigen::Isometry3d& pose, const ros::Time& stamp, const std::string& moving_frame);

  const Parameters parameters_;
  nav_msgs::Path path_;
  ros::Publisher odom_, twist_, pose_, transform_, path_publisher_;
  std::unique_ptr<TfLookup> tf_;  ///< with ~base_frame alone: tf is a busy topic
  WatchedBroadcaster& broadcaster_;
  ros::Time last_broadcast_;
  std::string problem_;
  Throttle throttle_;
  std::mutex set_mutex_;                 ///< guards the next
  std::optional<OdometryEstimate> set_;  ///< by ~set_pose, of the base
  ros::Subscriber set_pose_;             ///< last: its callback may run until it is gone
};

}  // namespace gms_ransac
