#include "priors/odometry_buffer.h"

#include <algorithm>

#include "priors/turns.h"

namespace gms_ransac {

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
    const Eigen::Vector3d turn = step * (a.angular + middle * (b.angular - a.angular));
    Eigen::Isometry3d part = Eigen::Isometry3d::Identity();
    part.linear() = turnOf(turn);
    part.translation() = turnOf(0.5 * turn) * (step * (a.velocity + middle * (b.velocity - a.velocity)));
    motion = motion * part;
    stamp = end;
  }
  return motion;
}

std::string OdometryBuffer::between(double from, double to, OdometryMotion& motion) const {
  if (samples_.size() < 2) return "no two samples have come";
  std::string problem = missing(from, to);
  if (!problem.empty()) return problem;
  const auto later = [](double stamp, const OdometrySample& sample) { return stamp < sample.stamp; };
  const auto after = [&](double stamp) {
    const auto found = std::upper_bound(samples_.begin(), samples_.end(), stamp, later);
    return std::min(static_cast<size_t>(found - samples_.begin()), samples_.size() - 1);
  };
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

}  // namespace gms_ransac
