// Broadcasts transforms while tf has a subscriber, each as the only node that broadcasts its frame: a second one would
// make tf jump between the two.
#pragma once

#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <geometry_msgs/TransformStamped.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>

#include "throttle.h"

namespace gms_ransac {

/// The first transforms of a frame are held until tf was listened to for a second. A frame that another node broadcasts
/// is refused for good. tf is a busy topic: it is listened to for some seconds more, in which two nodes that started
/// together notice each other, and then no longer.
class WatchedBroadcaster {
 public:
  /// `name`: of the node, for the log; a nodelet manager's process holds several.
  explicit WatchedBroadcaster(const std::string& name);
  ~WatchedBroadcaster();

  bool listened() const { return broadcaster_.getNumSubscribers() > 0; }
  /// Does nothing without a subscriber, and never waits for the master. Refuses a frame without a name, or that would
  /// be its own parent, with a warning. `for_good`: tf is listened to for as long as the process lives.
  void send(const geometry_msgs::TransformStamped& transform, bool for_good = false);
  /// Listens to tf where a frame is new, and broadcasts what was held. To be called every second, from a thread that
  /// may wait for the master. `master_answers` false: what was held is broadcast unwatched.
  void watch(bool master_answers);
  /// Why the last transform was not broadcast, and the remedy; empty: it was. From the thread of `send`.
  const std::string& problem() const { return problem_; }
  /// Sentence on a frame that another node broadcasts and this one therefore does not, with the remedy; empty: none.
  std::string refusal();

 private:
  struct Heard {
    std::string parent, node;
    bool same_process = false;
  };
  struct Frame {
    std::string parent;
    std::deque<ros::Time> sent;  ///< last stamps, while tf is listened to
    std::vector<geometry_msgs::TransformStamped> held;
    bool settled = false;  ///< no other node broadcasts it
    bool for_good = false;
    ros::SteadyTime since;  ///< when it was settled
    std::string refusal;
  };
  void listen();
  void onTransforms(const ros::MessageEvent<tf2_msgs::TFMessage const>& event);
  // With mutex_ held.
  void broadcast(const geometry_msgs::TransformStamped& transform, Frame& frame);
  void settle(Frame& frame);
  /// Another node broadcasts the frame.
  void contest(const std::string& child, const Heard& other, Frame& frame);
  bool mustListen() const;

  const std::string name_;
  Throttle throttle_;
  ros::NodeHandle nh_;  ///< as tf2_ros::TransformBroadcaster has it, not the nodelet's
  ros::Publisher broadcaster_;
  std::string problem_;

  std::mutex mutex_;  ///< guards what follows
  bool listening_ = false;
  ros::SteadyTime listening_since_;
  std::map<std::string, Heard> heard_;   ///< who broadcasts a frame, by child, while tf is listened to
  std::map<std::string, Frame> frames_;  ///< that this node broadcasts, by child

  std::vector<ros::Subscriber>
      subscribers_;  ///< used by `watch` alone; last: their callbacks may run until they are gone
};

}  // namespace gms_ransac
