// Broadcasts transforms that somebody listens to, refuses those that tf would, and notices another node that broadcasts
// the same ones.
#pragma once

#include <deque>
#include <mutex>
#include <set>
#include <string>

#include <geometry_msgs/TransformStamped.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>

#include "throttle.h"

namespace gms_ransac {

/// tf is a busy topic, so it is listened to only for a while after the first transform that is sent: of two nodes the
/// one that was started last notices the other.
class WatchedBroadcaster {
 public:
  /// `name`: of the node, for the log; a manager's process holds several.
  explicit WatchedBroadcaster(std::string name);

  /// Whether anyone listens to tf, this object and others of the process included.
  bool listened() const { return broadcaster_.getNumSubscribers() > 0; }
  /// Sends nothing while nobody listens. A frame without a name, or one that would be its own parent, is not broadcast
  /// and warned about once.
  void send(const geometry_msgs::TransformStamped& transform);

 private:
  void remember(const geometry_msgs::TransformStamped& transform);
  void onTransforms(const ros::MessageEvent<tf2_msgs::TFMessage const>& event);

  const std::string name_;
  ros::NodeHandle nh_;  ///< as tf2_ros::TransformBroadcaster has it, not the nodelet's
  ros::Publisher broadcaster_;
  Throttle throttle_;

  std::mutex mutex_;  ///< guards what follows
  ros::SteadyTime listening_since_;
  std::set<std::string> children_;                      ///< of the transforms sent while tf is listened to
  std::deque<geometry_msgs::TransformStamped> recent_;  ///< what comes back from tf and is ours
  ros::Subscriber tf_;                                  ///< last: its callback may run until it is gone
};

}  // namespace gms_ransac
