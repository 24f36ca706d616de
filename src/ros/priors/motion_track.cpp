#include "priors/motion_track.h"

#include <algorithm>
#include <cmath>

#include "text.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

constexpr double kRestart = 1;  // seconds back that start a new stream
constexpr double kKept = 30;    // seconds
// Metres, radians, seconds, and variances: no sensor measures more, and products of these are finite.
constexpr double kLargest = 1e9;

bool isPossible(const Eigen::Vector3d& v) { return v.squaredNorm() < kLargest * kLargest; }

}  // namespace

double MotionTrack::secondsTo(double stamp) {
  if (empty()) return 0;
  const double seconds = stamp - samples_.back().stamp;
  if (seconds > 0) {
    late_.end();
    return seconds;
  }
  if (seconds == 0 || (seconds > -kRestart && !late_.steppedBack(stamp))) return -1;
  clear();
  return 0;
}

void MotionTrack::append(double stamp, const Eigen::Isometry3d& step, double variance) {
  if (empty()) {
    samples_.push_back({stamp, Eigen::Isometry3d::Identity(), 0});
    return;
  }
  const Sample& last = samples_.back();
  Eigen::Isometry3d pose = last.pose * step;
  pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();  // or rounding adds up
  samples_.push_back({stamp, pose, last.variance + std::min(variance, kLargest)});
  while (samples_.front().stamp < stamp - kKept || samples_.size() > kMostSamples) samples_.pop_front();
}

size_t MotionTrack::after(double stamp) const {
  const auto later = [](double time, const Sample& sample) { return time < sample.stamp; };
  const auto found = std::upper_bound(samples_.begin(), samples_.end(), stamp, later);
  return std::min(std::max<size_t>(1, static_cast<size_t>(found - samples_.begin())), samples_.size() - 1);
}

MotionTrack::Sample MotionTrack::at(double stamp) const {
  const size_t next = after(stamp);
  const Sample &a = samples_[next - 1], &b = samples_[next];
  const double share = (stamp - a.stamp) / (b.stamp - a.stamp);
  Sample sample = {stamp, Eigen::Isometry3d::Identity(), a.variance + share * (b.variance - a.variance)};
  sample.pose.linear() =
      Eigen::Quaterniond(a.pose.linear()).slerp(share, Eigen::Quaterniond(b.pose.linear())).toRotationMatrix();
  sample.pose.translation() = a.pose.translation() + share * (b.pose.translation() - a.pose.translation());
  return sample;
}

std::string MotionTrack::between(double from, double to, TrackMotion& motion) const {
  if (samples_.size() < 2) return "no two samples have come";
  if (!reaches(to)) return "the newest sample is " + secondsText(to - samples_.back().stamp) + " too old";
  if (samples_.front().stamp > from)
    return "the samples start " + secondsText(samples_.front().stamp - from) + " later";
  for (size_t i = after(from); i < samples_.size() && samples_[i - 1].stamp < to; ++i) {
    const double step = samples_[i].stamp - samples_[i - 1].stamp;
    if (step > longest_step_) return "no sample came for " + secondsText(step) + " between them";
  }
  const Sample start = at(from), end = at(to);
  motion = {start.pose.inverse() * end.pose, std::max(0.0, end.variance - start.variance)};
  return std::string();
}

bool GyroTrack::add(double stamp, const Eigen::Vector3d& rate, double variance) {
  if (!std::isfinite(stamp) || !isPossible(rate)) return false;
  const double seconds = secondsTo(stamp);
  if (seconds < 0) return true;
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  if (seconds > 0) step.linear() = rotationFromVector(0.5 * seconds * (rate_ + rate));
  append(stamp, step, seconds * seconds * (variance > 0 ? variance : kUsualSigma * kUsualSigma));
  rate_ = rate;
  return true;
}

bool OdometryTrack::add(const OdometrySample& sample) {
  const bool possible = isPossible(sample.pose.translation()) && isPossible(sample.velocity);
  if (!possible || !isPossible(sample.angular) || !sample.pose.matrix().allFinite()) return false;
  const double seconds = secondsTo(sample.stamp);
  if (seconds < 0) return true;
  if (seconds == 0) last_ = sample;
  poses_change_ |= sample.pose.matrix() != last_.pose.matrix();
  Eigen::Isometry3d step = last_.pose.inverse() * sample.pose;
  if (!poses_change_) {
    const Eigen::Vector3d rotation = 0.5 * seconds * (last_.angular + sample.angular);
    step.linear() = rotationFromVector(rotation);
    step.translation() = rotationFromVector(0.5 * rotation) * (0.5 * seconds * (last_.velocity + sample.velocity));
  }
  append(sample.stamp, step, seconds * sample.velocity_variance);
  last_ = sample;
  return true;
}

}  // namespace gms_ransac
