#include "output/watched_broadcaster.h"

#include <algorithm>
#include <iterator>

#include <ros/console.h>
#include <ros/this_node.h>

namespace gms_ransac {

namespace {

constexpr double kSettlingSeconds = 1, kWatchSeconds = 10;
constexpr uint32_t kTransformQueue = 100;  // of tf2_ros::TransformBroadcaster
constexpr size_t kMostHeld = 1000;         // ten seconds of a fast camera; the oldest goes
constexpr size_t kRemembered = 300;        // transforms on their way back to this node

bool contains(const std::deque<ros::Time>& stamps, const ros::Time& stamp) {
  return std::find(stamps.begin(), stamps.end(), stamp) != stamps.end();
}

/// The nodelets of a process, whose transforms all come from one node: the first to claim a frame has it.
class Claims {
 public:
  /// Returns the name of the one that has it.
  std::string claim(const std::string& child, const std::string& name) {
    std::lock_guard<std::mutex> lock(mutex_);
    return owners_.try_emplace(child, name).first->second;
  }
  void release(const std::string& name) {
    std::lock_guard<std::mutex> lock(mutex_);
    for (auto each = owners_.begin(); each != owners_.end();) {
      each = each->second == name ? owners_.erase(each) : std::next(each);
    }
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::string> owners_;
};

Claims& claims() {
  static Claims* const all = new Claims();  // outlives every nodelet
  return *all;
}

double secondsSince(const ros::SteadyTime& time) { return (ros::SteadyTime::now() - time).toSec(); }

}  // namespace

WatchedBroadcaster::WatchedBroadcaster(const std::string& name)
    : name_(name), throttle_(name), broadcaster_(nh_.advertise<tf2_msgs::TFMessage>("/tf", kTransformQueue)) {}

WatchedBroadcaster::~WatchedBroadcaster() { claims().release(name_); }

void WatchedBroadcaster::send(const geometry_msgs::TransformStamped& transform, bool for_good) {
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
  std::lock_guard<std::mutex> lock(mutex_);
  const auto [at, is_new] = frames_.try_emplace(child);
  Frame& frame = at->second;
  frame.parent = parent;
  frame.for_good = for_good;
  const auto heard = heard_.find(child);
  if (is_new && heard != heard_.end()) contest(child, heard->second, frame);
  if (is_new && frame.refusal.empty()) {
    const std::string owner = claims().claim(child, name_);
    if (owner != name_) contest(child, {parent, owner, false}, frame);
  }
  if (!frame.refusal.empty()) return;
  if (frame.settled) return broadcast(transform, frame);
  if (frame.held.size() == kMostHeld) frame.held.erase(frame.held.begin());
  frame.held.push_back(transform);
  if (listening_ && secondsSince(listening_since_) >= kSettlingSeconds) settle(frame);
}

void WatchedBroadcaster::broadcast(const geometry_msgs::TransformStamped& transform, Frame& frame) {
  if (listening_) frame.sent.push_back(transform.header.stamp);
  if (frame.sent.size() > kRemembered) frame.sent.pop_front();
  tf2_msgs::TFMessage message;
  message.transforms.push_back(transform);
  broadcaster_.publish(message);
}

void WatchedBroadcaster::settle(Frame& frame) {
  frame.settled = true;
  frame.since = ros::SteadyTime::now();
  for (const geometry_msgs::TransformStamped& transform : frame.held) broadcast(transform, frame);
  frame.held.clear();
}

bool WatchedBroadcaster::mustListen() const {
  return std::any_of(frames_.begin(), frames_.end(), [](const auto& each) {
    const Frame& frame = each.second;
    return frame.refusal.empty() && (!frame.settled || frame.for_good || secondsSince(frame.since) < kWatchSeconds);
  });
}

void WatchedBroadcaster::watch(bool master_answers) {
  bool needed;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    needed = mustListen();
    const bool settled = !master_answers || (listening_ && secondsSince(listening_since_) >= kSettlingSeconds);
    for (auto& [child, frame] : frames_) {
      if (settled && !frame.settled && frame.refusal.empty()) settle(frame);
    }
  }
  if (!master_answers) return;
  if (needed) return listen();
  if (subscribers_.empty()) return;
  subscribers_.clear();  // without the lock, for which a callback may be waiting
  std::lock_guard<std::mutex> lock(mutex_);
  listening_ = false;
  heard_.clear();
  for (auto& [child, frame] : frames_) frame.sent.clear();
}

void WatchedBroadcaster::listen() {
  if (!subscribers_.empty()) return;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    listening_ = true;  // from now on what is sent comes back
    listening_since_ = ros::SteadyTime::now();
  }
  for (const char* topic : {"/tf", "/tf_static"}) {
    subscribers_.push_back(nh_.subscribe(topic, kTransformQueue, &WatchedBroadcaster::onTransforms, this));
  }
  std::lock_guard<std::mutex> lock(mutex_);
  listening_since_ = ros::SteadyTime::now();
}

void WatchedBroadcaster::onTransforms(const ros::MessageEvent<tf2_msgs::TFMessage const>& event) {
  const std::string& node = event.getPublisherName();
  const bool same_process = node == ros::this_node::getName();
  std::lock_guard<std::mutex> lock(mutex_);
  for (const geometry_msgs::TransformStamped& transform : event.getConstMessage()->transforms) {
    const std::string& child = transform.child_frame_id;
    const auto ours = frames_.find(child);
    if (ours != frames_.end() && same_process && contains(ours->second.sent, transform.header.stamp)) continue;
    const Heard heard = {transform.header.frame_id, node, same_process};
    heard_[child] = heard;
    if (ours != frames_.end() && ours->second.refusal.empty()) contest(child, heard, ours->second);
  }
}

void WatchedBroadcaster::contest(const std::string& child, const Heard& other, Frame& frame) {
  const std::string who = (other.same_process ? "another nodelet of " : "") + other.node +
                          " broadcasts the transform " + other.parent + " -> " + child;
  // Two that started together hear each other: the first by name goes on.
  const bool goes_on =
      frame.settled && other.parent == frame.parent && (other.same_process || ros::this_node::getName() < other.node);
  if (goes_on) {
    return throttle_.warnOnce(child, who + ", and so does " + name_ +
                                         ": tf jumps between the two; switch one off (~publish_odom_tf, "
                                         "~publish_relative_tf)");
  }
  frame.refusal = who + ", and a frame can have only one parent and one broadcaster: " + frame.parent + " -> " + child +
                  " is not broadcast; switch one off (~publish_odom_tf, ~publish_relative_tf), or set ~invert_odom_tf";
  frame.held.clear();
  ROS_ERROR_STREAM(name_ << ": " << frame.refusal);
}

std::string WatchedBroadcaster::refusal() {
  std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [child, frame] : frames_) {
    if (!frame.refusal.empty()) return frame.refusal;
  }
  return std::string();
}

}  // namespace gms_ransac
