#include "priors/wheel_source.h"

#include <algorithm>
#include <cmath>

#include <nav_msgs/Odometry.h>

#include "frames.h"

namespace gms_ransac {

namespace {

constexpr uint32_t kOdometryQueue = 200;  // a second of fast wheels
// Standard deviation of a length: a share of it, for the radius of the wheels and the ground, and a tick, metres.
constexpr double kWheelShare = 0.03, kWheelTick = 0.001;

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
  // Axes that a robot does not have are often given huge variances: forward is the one that wheels measure.
  sample.velocity_variance = std::max(0.0, odometry.twist.covariance[0]);
  return sample;
}

}  // namespace

WheelRotation::WheelRotation(const ros::NodeHandle& nh, const Parameters& parameters, TfLookup& tf)
    : RotationSource(nh.resolveName("prior_odom"), parameters.image_time_offset),
      nh_(nh),
      wheels_(nh.resolveName("prior_odom"), tf) {}

void WheelRotation::start(const std::function<void()>& arrived) {
  if (subscriber_) return;
  wheels_.clear();
  const auto add = [this, arrived](const nav_msgs::OdometryConstPtr& odometry) {
    const std::string frame = withoutLeadingSlash(odometry->child_frame_id);
    wheels_.note(frame, frame.empty() ? "no child_frame_id; set it to the frame that moves" : "",
                 [&](OdometryTrack& track) { return track.add(toSample(*odometry)); });
    arrived();
  };
  subscriber_ = nh_.subscribe<nav_msgs::Odometry>("prior_odom", kOdometryQueue, add, ros::VoidConstPtr(),
                                                  ros::TransportHints().tcpNoDelay());
}

std::string WheelRotation::between(const PriorQuery& query, TrackMotion& motion) const {
  Eigen::Isometry3d camera_in_body;
  std::string problem = wheels_.between(query, motion, camera_in_body);
  if (problem.empty()) motion.motion = camera_in_body.inverse() * motion.motion * camera_in_body;
  return problem;
}

RotationAnswer WheelRotation::measure(const PriorQuery& query) {
  TrackMotion odometry;
  RotationAnswer answer;
  answer.problem = between(query, odometry);
  if (answer.problem.empty()) answer.prior = priorOfPoses(odometry.motion.linear());
  return answer;
}

LengthAnswer WheelLength::measure(const PriorQuery& query, const PairSeen& pair) {
  if (learns_ && pair.seen.judgement.pose_found) {
    const RotationAnswer rotation = wheels_->ask(query);
    if (rotation.prior) wheels_->compare(rotation, pair.seen);
  }
  TrackMotion odometry;
  LengthAnswer answer;
  answer.problem = query.from < query.to ? wheels_->between(wheels_->onSensorClock(query), odometry)
                                         : "the reference is not before the current image";
  if (answer.problem.empty()) answer.problem = check_.judge(odometry.motion.translation(), pair.seen);
  if (!answer.problem.empty()) return answer;
  const double length = odometry.motion.translation().norm();
  const double seconds = query.to - query.from, share = kWheelShare * length;
  const double variance = std::max(share * share, odometry.variance * seconds);
  answer.length = {length, std::sqrt(variance + kWheelTick * kWheelTick) / std::max(length, kWheelTick), 1};
  return answer;
}

PriorReport WheelLength::report() {
  PriorReport report = LengthSource::report();
  if (!learns_) return report;
  PriorReport of_rotation = wheels_->report();
  report.values = std::move(of_rotation.values);
  report.found = std::move(of_rotation.found);
  return report;
}

}  // namespace gms_ransac
