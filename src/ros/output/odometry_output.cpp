#include "output/odometry_output.h"

#include <utility>

#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/TwistWithCovarianceStamped.h>

#include "frames.h"
#include "output/output_options.h"
#include "output/watched_broadcaster.h"
#include "tf_lookup.h"

namespace gms_ransac {

namespace {

constexpr size_t kPathPoses = 2000;  // a minute of a 30 Hz camera, in messages of 200 kB; then every second one

}  // namespace

OdometryOutput::OdometryOutput(const ros::NodeHandle& nh, ros::NodeHandle& outputs, const Parameters& parameters,
                               WatchedBroadcaster& broadcaster, const ros::SubscriberStatusCallback& changed)
    : parameters_(parameters), broadcaster_(broadcaster), throttle_(parameters.name) {
  // From the start, or the first pairs would find no place of the camera on its base.
  if (!parameters_.base_frame.empty()) tf_ = std::make_unique<TfLookup>(nh);
  odom_ = outputs.advertise<nav_msgs::Odometry>("odom", kPublisherQueue, changed, changed);
  twist_ = outputs.advertise<geometry_msgs::TwistWithCovarianceStamped>("twist", kPublisherQueue, changed, changed);
  pose_ = outputs.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", kPublisherQueue, changed, changed);
  transform_ = outputs.advertise<geometry_msgs::TransformStamped>("transform", kPublisherQueue, changed, changed);
  path_publisher_ = outputs.advertise<nav_msgs::Path>("path", 1, changed, changed);
  set_pose_ = outputs.subscribe<geometry_msgs::PoseWithCovarianceStamped>(
      "set_pose", 1, [this](const geometry_msgs::PoseWithCovarianceStampedConstPtr& message) { onSetPose(*message); });
}

OdometryOutput::~OdometryOutput() = default;

int OdometryOutput::listeners() const {
  uint32_t count = 0;
  for (const ros::Publisher* publisher : {&odom_, &twist_, &pose_, &transform_, &path_publisher_}) {
    count += publisher->getNumSubscribers();
  }
  return static_cast<int>(count);
}

void OdometryOutput::onSetPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const geometry_msgs::Point& p = message.pose.pose.position;
  const geometry_msgs::Quaternion& q = message.pose.pose.orientation;
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  OdometryEstimate base;
  base.pose = Eigen::Translation3d(p.x, p.y, p.z) * rotation.normalized();
  base.pose_covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.pose.covariance.data());
  const std::string frame = withoutLeadingSlash(message.header.frame_id);
  if (frame != parameters_.odom_frame) {
    throttle_.warn("set pose", "~set_pose in the frame '" + frame + "' is not used; send it in ~odom_frame, '" +
                                   parameters_.odom_frame + "'");
  } else if (!base.pose.matrix().allFinite() || !base.pose_covariance.allFinite() || rotation.norm() < 0.5) {
    throttle_.warn("set pose", "~set_pose is not used: it is not finite, or its orientation is no unit quaternion");
  } else {
    std::lock_guard<std::mutex> lock(set_mutex_);
    set_ = base;
  }
}

std::optional<OdometryEstimate> OdometryOutput::popSetPose(const std_msgs::Header& camera) {
  std::lock_guard<std::mutex> lock(set_mutex_);
  const auto camera_in_base = set_ ? cameraInBase(camera) : std::nullopt;
  if (!camera_in_base) return std::nullopt;
  MotionIntegrator base;
  base.set(set_->pose, set_->pose_covariance);
  set_.reset();
  return base.base(camera_in_base->inverse());
}

void OdometryOutput::publish(const ProcessedFrame& processed, bool with_transform) {
  if (processed.continuity == Continuity::kRestarted && tf_) tf_->clear();
  if (processed.place_restarted) path_.poses.clear();
  if (!processed.place || (listeners() == 0 && !with_transform)) return;
  const std_msgs::Header& header = processed.current->image.header;
  const auto camera_in_base = cameraInBase(header);
  if (!camera_in_base) return;
  problem_.clear();

  const bool at_origin = processed.pair == nullptr;
  OdometryEstimate estimate = processed.place->base(*camera_in_base);
  const std::string& moving_frame = parameters_.base_frame.empty() ? header.frame_id : parameters_.base_frame;
  if (!parameters_.givesMetres()) {
    // A filter that fuses rotations, as example_robot_localization.launch has it, reads ~twist alone.
    if (hasSubscriber(odom_) || hasSubscriber(pose_) || hasSubscriber(transform_)) {
      throttle_.warnOnce("no metres",
                         "~odom, ~pose and ~twist are not in metres with ~scale unit or propagate: their "
                         "velocities have variances of 1e6; set ~scale to depth, fixed, odometry or ground for metres");
    } else if (hasSubscriber(twist_)) {
      throttle_.infoOnce("no metres in ~twist",
                         "the linear velocity of ~twist is not in metres with ~scale unit or propagate and has a "
                         "variance of 1e6: fuse its rotation alone");
    }
    // The origin is known; a filter that starts there and hears of it later does not move by what follows. No velocity
    // is the same in any unit.
    if (!at_origin) forgetLength(processed.atRest(), estimate);
  }
  std_msgs::Header in_odom = header;
  in_odom.frame_id = parameters_.odom_frame;
  nav_msgs::Odometry odom;
  odom.header = in_odom;
  odom.child_frame_id = moving_frame;
  odom.pose = toMessage(estimate.pose, estimate.pose_covariance);
  odom.twist = toMessage(estimate.twist, estimate.twist_covariance);
  if (hasSubscriber(pose_)) {
    geometry_msgs::PoseWithCovarianceStamped pose;
    pose.header = in_odom;
    pose.pose = odom.pose;
    publishShared(pose_, std::move(pose));
  }
  if (hasSubscriber(transform_)) {
    geometry_msgs::TransformStamped transform = toTransform(estimate.pose);
    transform.header = in_odom;
    transform.child_frame_id = moving_frame;
    publishShared(transform_, std::move(transform));
  }
  if (hasSubscriber(twist_) && !at_origin) {
    geometry_msgs::TwistWithCovarianceStamped twist;
    twist.header.stamp = header.stamp;
    twist.header.frame_id = moving_frame;
    twist.twist = odom.twist;
    publishShared(twist_, std::move(twist));
  }
  publishPath(odom);
  publishShared(odom_, std::move(odom));
  if (with_transform) broadcast(estimate.pose, header.stamp, moving_frame);
}

void OdometryOutput::publishPath(const nav_msgs::Odometry& odom) {
  geometry_msgs::PoseStamped pose;
  pose.header = odom.header;
  pose.pose = odom.pose.pose;
  if (path_.poses.size() >= kPathPoses) {  // every second one stays
    for (size_t i = 0; 2 * i < path_.poses.size(); ++i) path_.poses[i] = path_.poses[2 * i];
    path_.poses.resize(path_.poses.size() / 2);
  }
  path_.header = odom.header;
  path_.poses.push_back(pose);
  if (hasSubscriber(path_publisher_)) publishShared(path_publisher_, nav_msgs::Path(path_));
}

std::optional<Eigen::Isometry3d> OdometryOutput::cameraInBase(const std_msgs::Header& camera) {
  if (parameters_.base_frame.empty() || parameters_.base_frame == camera.frame_id) return Eigen::Isometry3d::Identity();
  // A camera moves little on its body within the moment that tf is late: the latest is the next best.
  std::string problem;
  for (const double stamp : {camera.stamp.toSec(), 0.}) {
    Eigen::Isometry3d camera_in_base;
    problem = tf_->get(parameters_.base_frame, camera.frame_id, stamp, camera_in_base);
    if (problem.empty()) return camera_in_base;
  }
  problem_ = "no ~odom in ~base_frame: " + problem;
  throttle_.warn("base frame", problem_);
  return std::nullopt;
}

void OdometryOutput::broadcast(const Eigen::Isometry3d& pose, const ros::Time& stamp, const std::string& moving_frame) {
  const bool inverted = parameters_.invert_odom_tf;
  const std::string& parent = inverted ? moving_frame : parameters_.odom_frame;
  const std::string& child = inverted ? parameters_.odom_frame : moving_frame;
  if (stamp == last_broadcast_) return;
  geometry_msgs::TransformStamped transform = toTransform(inverted ? pose.inverse() : pose);
  transform.header.stamp = stamp;
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  constexpr bool kForGood = true;  // a localization that is started later may claim the frame
  broadcaster_.send(transform, kForGood);
  last_broadcast_ = stamp;
}

}  // namespace gms_ransac
