#include "output/watched_broadcaster.h"

#include <algorithm>
#include <utility>

#include <ros/master.h>
#include <ros/this_node.h>

namespace gms_ransac {

namespace {

constexpr double kListenSeconds = 10;
constexpr uint32_t kTransformQueue = 100;  // of tf2_ros::TransformBroadcaster
// Of ours on their way through tf; far more than a fast camera sends in the time a message takes.
constexpr size_t kRecent = 500;

}  // namespace

WatchedBroadcaster::WatchedBroadcaster(std::string name)
    : name_(std::move(name)), broadcaster_(nh_.advertise<tf2_msgs::TFMessage>("/tf", kTransformQueue)) {}

void WatchedBroadcaster::send(const geometry_msgs::TransformStamped& transform) {
  if (!listened()) return;
  const std::string &parent = transform.header.frame_id, &child = transform.child_frame_id;
  if (parent.empty() || child.empty()) {
    throttle_.warnOnce("no name",
                       name_ +
                           ": no transform of the camera is broadcast: the images have no frame_id; set it where "
                           "they are published");
    return;
  }
  if (parent == child) {
    throttle_.warnOnce("itself", name_ + ": no transform is broadcast: " + child +
                                     " would be its own parent; set ~odom_frame and ~base_frame to different frames");
    return;
  }
  remember(transform);
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  broadcaster_.publish(message);
}

void WatchedBroadcaster::remember(const geometry_msgs::TransformStamped& transform) {
  ros::Subscriber done;  // let go without the lock, for which its callback may be waiting
  std::lock_guard<std::mutex> lock(mutex_);
  if (listening_since_.isZero()) {
    // To subscribe waits for a master, and the images would with it; what is connected goes on without.
    if (!ros::master::check()) return;
    listening_since_ = ros::SteadyTime::now();
    tf_ = nh_.subscribe("/tf", kTransformQueue, &WatchedBroadcaster::onTransforms, this);
  }
  if ((ros::SteadyTime::now() - listening_since_).toSec() > kListenSeconds) std::swap(done, tf_);
  if (!tf_) return;
  children_.insert(transform.child_frame_id);
  recent_.push_back(transform);
  if (recent_.size() > kRecent) recent_.pop_front();
}

void WatchedBroadcaster::onTransforms(const ros::MessageEvent<tf2_msgs::TFMessage const>& event) {
  const bool same_process = event.getPublisherName() == ros::this_node::getName();
  const std::string publisher = (same_process ? "another nodelet of " : "") + event.getPublisherName();
  std::lock_guard<std::mutex> lock(mutex_);
  for (const geometry_msgs::TransformStamped& transform : event.getConstMessage()->transforms) {
    const std::string &parent = transform.header.frame_id, &child = transform.child_frame_id;
    if (children_.count(child) == 0 || std::find(recent_.begin(), recent_.end(), transform) != recent_.end()) continue;
    throttle_.warnOnce(child, publisher + " broadcasts a transform " + parent + " -> " + child + ", and so does " +
                                  name_ +
                                  ": one of the two must stop (~publish_odom_tf, ~publish_relative_tf), or "
                                  "tf jumps between them");
  }
}

}  // namespace gms_ransac
