#include "priors/odometry_input.h"

#include <algorithm>
#include <utility>

#include "frames.h"

namespace gms_ransac {

namespace {

constexpr uint32_t kOdometryQueue = 200;  // a second of fast wheels

OdometrySample toSample(const nav_msgs::Odometry& odometry) {
  OdometrySample sample;
  sample.stamp = odometry.header.stamp.toSec();
  const auto& p = odometry.pose.pose.position;
  const auto& q = odometry.pose.pose.orientation;
  sample.pose.translation() = Eigen::Vector3d(p.x, p.y, p.z);
  const Eigen::Quaterniond turn(q.w, q.x, q.y, q.z);
  // All zeros is what a message has that fills only its twist.
  if (turn.norm() > 0.5) sample.pose.linear() = turn.normalized().toRotationMatrix();
  const auto& twist = odometry.twist.twist;
  sample.velocity = {twist.linear.x, twist.linear.y, twist.linear.z};
  sample.angular = {twist.angular.x, twist.angular.y, twist.angular.z};
  const auto& covariance = odometry.twist.covariance;
  // Axes that a robot does not have are often given huge variances: forward is the one that wheels measure.
  sample.velocity_variance = std::max(0.0, covariance[0]);
  return sample;
}

}  // namespace

OdometryInput::OdometryInput(const ros::NodeHandle& nh, std::shared_ptr<TfLookup> tf, std::function<void()> arrived)
    : nh_(nh), tf_(std::move(tf)), arrived_(std::move(arrived)) {}

void OdometryInput::start() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    samples_.clear();
  }
  subscriber_ =
      nh_.subscribe("prior_odom", kOdometryQueue, &OdometryInput::onOdometry, this, ros::TransportHints().tcpNoDelay());
}

void OdometryInput::stop() { subscriber_.shutdown(); }

void OdometryInput::onOdometry(const nav_msgs::OdometryConstPtr& odometry) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    samples_.add(toSample(*odometry));
    body_frame_ = withoutLeadingSlash(odometry->child_frame_id);
  }
  arrived_();
}

bool OdometryInput::reaches(double stamp) {
  std::lock_guard<std::mutex> lock(mutex_);
  return samples_.reaches(stamp);
}

std::string OdometryInput::between(const std::string& camera_frame, double from, double to, OdometryMotion& motion) {
  const std::string topic = nh_.resolveName("prior_odom");
  std::string body_frame;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (samples_.empty()) return "no message has come on " + topic;
    const std::string problem = samples_.between(from, to, motion);
    if (!problem.empty()) return problem + " on " + topic;
    body_frame = body_frame_;
  }
  if (body_frame.empty()) return "the messages on " + topic + " have no child_frame_id, which says what moves";
  Eigen::Isometry3d camera_in_body;
  std::string problem = tf_->get(body_frame, camera_frame, 0, camera_in_body);
  motion.motion = camera_in_body.inverse() * motion.motion * camera_in_body;
  return problem;
}

}  // namespace gms_ransac
