#include "priors/odometry_input.h"

#include <algorithm>
#include <utility>

#include "frames.h"
#include "priors/rotation_vectors.h"
#include "tf_lookup.h"

namespace gms_ransac {

namespace {

constexpr uint32_t kOdometryQueue = 200;  // a second of fast wheels

OdometrySample toSample(const nav_msgs::Odometry& odometry) {
  OdometrySample sample;
  sample.stamp = odometry.header.stamp.toSec();
  const auto& p = odometry.pose.pose.position;
  const auto& q = odometry.pose.pose.orientation;
  sample.pose.translation() = Eigen::Vector3d(p.x, p.y, p.z);
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  // All zeros is what a message has that fills only its twist.
  if (rotation.norm() > 0.5) sample.pose.linear() = rotation.normalized().toRotationMatrix();
  const auto& twist = odometry.twist.twist;
  sample.velocity = {twist.linear.x, twist.linear.y, twist.linear.z};
  sample.angular = {twist.angular.x, twist.angular.y, twist.angular.z};
  const auto& covariance = odometry.twist.covariance;
  // Axes that a robot does not have are often given huge variances: forward is the one that wheels measure.
  sample.velocity_variance = std::max(0.0, covariance[0]);
  return sample;
}

}  // namespace

void OdometryBuffer::add(const OdometrySample& sample) {
  if (!sample.pose.matrix().allFinite() || !sample.velocity.allFinite() || !sample.angular.allFinite()) return;
  SampleBuffer::add(sample);
}

bool OdometryBuffer::posesMove() const {
  const auto& first = samples_.front().pose.matrix();
  const auto differs = [&](const OdometrySample& sample) { return sample.pose.matrix() != first; };
  const auto has_speed = [](const OdometrySample& s) { return !s.velocity.isZero() || !s.angular.isZero(); };
  return std::any_of(samples_.begin(), samples_.end(), differs) ||
         std::none_of(samples_.begin(), samples_.end(), has_speed);
}

Eigen::Isometry3d OdometryBuffer::poseAt(size_t after, double stamp) const {
  const OdometrySample &a = samples_[after - 1], &b = samples_[after];
  const double share = (stamp - a.stamp) / (b.stamp - a.stamp);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() =
      Eigen::Quaterniond(a.pose.linear()).slerp(share, Eigen::Quaterniond(b.pose.linear())).toRotationMatrix();
  pose.translation() = a.pose.translation() + share * (b.pose.translation() - a.pose.translation());
  return pose;
}

Eigen::Isometry3d OdometryBuffer::integrateTwist(size_t after, double from, double to) const {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  for (double stamp = from; stamp < to; ++after) {
    const OdometrySample &a = samples_[after - 1], &b = samples_[after];
    const double end = std::min(to, b.stamp), step = end - stamp;
    const double middle = (0.5 * (stamp + end) - a.stamp) / (b.stamp - a.stamp);
    const Eigen::Vector3d rotation = step * (a.angular + middle * (b.angular - a.angular));
    Eigen::Isometry3d part = Eigen::Isometry3d::Identity();
    part.linear() = rotationBy(rotation);
    part.translation() = rotationBy(0.5 * rotation) * (step * (a.velocity + middle * (b.velocity - a.velocity)));
    motion = motion * part;
    stamp = end;
  }
  return motion;
}

std::string OdometryBuffer::between(double from, double to, OdometryMotion& motion) const {
  if (samples_.size() < 2) return "no two samples have come";
  std::string problem = missing(from, to);
  if (!problem.empty()) return problem;
  const size_t first = after(from), last = after(to);
  motion = OdometryMotion();
  for (size_t i = first; i <= last; ++i) {
    const double step = samples_[i].stamp - samples_[i - 1].stamp;
    if (step > kLongestStep) return missingStep(step);
    motion.velocity_variance += samples_[i].velocity_variance / static_cast<double>(last - first + 1);
  }
  motion.motion = posesMove() ? poseAt(first, from).inverse() * poseAt(last, to) : integrateTwist(first, from, to);
  return std::string();
}

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
  if (body_frame.empty()) return "the messages on " + topic + " have no child_frame_id; set it to the frame that moves";
  Eigen::Isometry3d camera_in_body;
  std::string problem = tf_->get(body_frame, camera_frame, 0, camera_in_body);
  motion.motion = camera_in_body.inverse() * motion.motion * camera_in_body;
  return problem;
}

}  // namespace gms_ransac
