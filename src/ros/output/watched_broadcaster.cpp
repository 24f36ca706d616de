#include "output/watched_broadcaster.h"

#include <utility>

#include <ros/master.h>
#include <ros/this_node.h>

namespace gms_ransac {

namespace {

constexpr double kWatchSeconds = 10;
constexpr uint32_t kTransformQueue = 100;  // of tf2_ros::TransformBroadcaster

}  // namespace

WatchedBroadcaster::WatchedBroadcaster(const std::string& name)
    : name_(name), throttle_(name), broadcaster_(nh_.advertise<tf2_msgs::TFMessage>("/tf", kTransformQueue)) {}

void WatchedBroadcaster::send(const geometry_msgs::TransformStamped& transform) {
  if (!listened()) return;
  const std::string &parent = transform.header.frame_id, &child = transform.child_frame_id;
  problem_.clear();
  if (parent.empty() || child.empty()) {
    problem_ = "no transform is broadcast: the images have no frame_id; set it where they are published";
  } else if (parent == child) {
    problem_ = "no transform is broadcast: " + child +
               " would be its own parent; set ~odom_frame and ~base_frame to different frames";
  }
  if (!problem_.empty()) return throttle_.warn(problem_, problem_);
  watch(transform);
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  broadcaster_.publish(message);
}

void WatchedBroadcaster::watch(const geometry_msgs::TransformStamped& sent) {
  ros::Subscriber done;  // ends without the lock, for which its callback may be waiting
  std::lock_guard<std::mutex> lock(mutex_);
  // Subscribing waits for a master that is gone, and the images would wait, too.
  if (sent_.count(sent.child_frame_id) == 0 && ros::master::check()) {
    watching_since_ = ros::SteadyTime::now();
    if (!tf_) tf_ = nh_.subscribe("/tf", kTransformQueue, &WatchedBroadcaster::onTransforms, this);
    sent_[sent.child_frame_id];
  }
  if ((ros::SteadyTime::now() - watching_since_).toSec() > kWatchSeconds) std::swap(done, tf_);
  if (tf_) sent_[sent.child_frame_id].insert(sent.header.stamp);
}

void WatchedBroadcaster::onTransforms(const ros::MessageEvent<tf2_msgs::TFMessage const>& event) {
  const bool same_process = event.getPublisherName() == ros::this_node::getName();
  std::lock_guard<std::mutex> lock(mutex_);
  for (const geometry_msgs::TransformStamped& transform : event.getConstMessage()->transforms) {
    const auto ours = sent_.find(transform.child_frame_id);
    if (ours == sent_.end() || (same_process && ours->second.count(transform.header.stamp) > 0)) continue;
    throttle_.warnOnce(ours->first, (same_process ? "another nodelet of " : "") + event.getPublisherName() +
                                        " broadcasts the transform " + transform.header.frame_id + " -> " +
                                        ours->first + ", and so does " + name_ +
                                        ": tf jumps between the two; switch one off (~publish_odom_tf, "
                                        "~publish_relative_tf)");
  }
}

}  // namespace gms_ransac
