#include "priors/sample_buffers.h"

#include <algorithm>
#include <cmath>

#include "priors/rotation_vectors.h"

namespace gms_ransac {

void GyroBuffer::add(const GyroSample& sample) {
  if (std::isfinite(sample.stamp) && sample.rate.allFinite()) SampleBuffer::add(sample);
}

std::string GyroBuffer::integrate(double from, double to, const Eigen::Vector3d& bias, GyroRotation& rotation) const {
  std::string problem = missing(from, to, kLongestStep);
  if (!problem.empty()) return problem;
  const auto rateAt = [this](size_t after, double stamp) -> Eigen::Vector3d {
    const GyroSample &a = samples_[after - 1], &b = samples_[after];
    return a.rate + (stamp - a.stamp) / (b.stamp - a.stamp) * (b.rate - a.rate);
  };
  rotation = GyroRotation();
  size_t after = this->after(from);
  const Eigen::Vector3d first_rate = rateAt(after, from);
  Eigen::Vector3d rate = first_rate;
  double variance = 0;
  for (double stamp = from; stamp < to; ++after) {
    const GyroSample& sample = samples_[after];
    const double end = std::min(to, sample.stamp);
    const Eigen::Vector3d end_rate = rateAt(after, end);
    rotation.R = rotation.R * rotationBy((end - stamp) * (0.5 * (rate + end_rate) - bias));
    // A sample stands for one step, of which this may be a part.
    const double sigma = sample.variance > 0 ? std::sqrt(sample.variance) : kUsualSigma;
    variance += (end - stamp) * (sample.stamp - samples_[after - 1].stamp) * sigma * sigma;
    stamp = end;
    rate = end_rate;
  }
  rotation.covariance.diagonal().setConstant(variance);
  rotation.rate_change = (rate - first_rate).norm();
  return std::string();
}

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
  std::string problem = missing(from, to, kLongestStep);
  if (!problem.empty()) return problem;
  const size_t first = after(from), last = after(to);
  motion = OdometryMotion();
  for (size_t i = first; i <= last; ++i) {
    motion.velocity_variance += samples_[i].velocity_variance / static_cast<double>(last - first + 1);
  }
  motion.motion = posesMove() ? poseAt(first, from).inverse() * poseAt(last, to) : integrateTwist(first, from, to);
  return std::string();
}

}  // namespace gms_ransac
