// Broadcasts transforms while tf has a subscriber, and warns of another node that broadcasts the same ones.
#pragma once

#include <map>
#include <mutex>
#include <set>
#include <string>

#include <geometry_msgs/TransformStamped.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>

#include "throttle.h"

namespace gms_ransac {

/// tf is a busy topic: it is subscribed to for some seconds after the first transform of a frame, so that of two nodes
/// the one started last notices the other.
class WatchedBroadcaster {
 public:
  /// `name`: of the node, for the log; a nodelet manager's process holds several.
  explicit WatchedBroadcaster(const std::string& name);

  bool listened() const { return broadcaster_.getNumSubscribers() > 0; }
  /// Does nothing without a subscriber. A frame without a name or that would be its own parent is refused with a
  /// warning.
  void send(const geometry_msgs::TransformStamped& transform);
  /// Why the last transform was refused, and the remedy; empty: it was not. From the thread of `send`.
  const std::string& problem() const { return problem_; }

 private:
  void watch(const geometry_msgs::TransformStamped& sent);
  void onTransforms(const ros::MessageEvent<tf2_msgs::TFMessage const>& event);

  const std::string name_;
  Throttle throttle_;
  ros::NodeHandle nh_;  ///< as tf2_ros::TransformBroadcaster has it, not the nodelet's
  ros::Publisher broadcaster_;
  std::string problem_;

  std::mutex mutex_;  ///< guards what follows
  ros::SteadyTime watching_since_;
  std::map<std::string, std::set<ros::Time>> sent_;  ///< stamps by child, while tf is watched
  ros::Subscriber tf_;                               ///< last: its callback may run until it is gone
};

}  // namespace gms_ransac
