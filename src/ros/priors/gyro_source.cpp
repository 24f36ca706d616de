#include "priors/gyro_source.h"

#include <algorithm>
#include <cmath>

#include <sensor_msgs/Imu.h>
#include <opencv2/core.hpp>

#include "frames.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

constexpr uint32_t kImuQueue = 1000;  // a second of a fast IMU
// Of extrinsics that were measured with a ruler, radians; and of the stamps of two drivers, seconds.
constexpr double kMountSigma = 0.01, kStampSigma = 0.002;

}  // namespace

GyroSource::GyroSource(const ros::NodeHandle& nh, const Parameters& parameters, TfLookup& tf)
    : RotationSource(parameters.image_time_offset),
      nh_(nh),
      imu_frame_(parameters.imu_frame),
      gyro_(nh.resolveName("imu"), tf) {}

void GyroSource::start(const std::function<void()>& arrived) {
  gyro_.clear();
  const auto add = [this, arrived](const sensor_msgs::ImuConstPtr& imu) {
    const auto& rate = imu->angular_velocity;
    const auto& covariance = imu->angular_velocity_covariance;
    const std::string frame = imu_frame_.empty() ? withoutLeadingSlash(imu->header.frame_id) : imu_frame_;
    const bool no_gyro = covariance[0] < 0;  // by its .msg
    const std::string defect = no_gyro         ? "no angular velocity (covariance -1); use an IMU with a gyro"
                               : frame.empty() ? "no frame_id; set ~imu_frame"
                                               : "";
    const double variance = std::max({0.0, covariance[0], covariance[4], covariance[8]});
    gyro_.note(frame, defect, [&](GyroTrack& track) {
      return no_gyro || track.add(imu->header.stamp.toSec(), {rate.x, rate.y, rate.z}, variance);
    });
    arrived();
  };
  subscriber_ =
      nh_.subscribe<sensor_msgs::Imu>("imu", kImuQueue, add, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

GyroBias GyroSource::bias() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return bias_;
}

std::string GyroSource::integrate(const PriorQuery& query, RotationPrior& prior) const {
  TrackMotion rotation, earlier;
  Eigen::Isometry3d camera_in_imu;
  std::string problem = gyro_.between(query, rotation, camera_in_imu);
  if (!problem.empty()) return problem;
  const GyroBias known = bias();
  const double seconds = query.to - query.from;
  const Eigen::Matrix3d less_bias = rotationFromVector(-0.5 * seconds * known.bias());
  prior.R =
      camera_in_imu.linear().transpose() * less_bias * rotation.motion.linear() * less_bias * camera_in_imu.linear();
  const double mount = kMountSigma * rotationVector(prior.R).norm();
  double variance = rotation.variance + seconds * seconds * known.variance() + mount * mount;
  // The change if the stamps were late by their standard deviation.
  if (gyro_.between(query.from - kStampSigma, query.to - kStampSigma, earlier).empty()) {
    variance += rotationVector(rotation.motion.linear().transpose() * earlier.motion.linear()).squaredNorm();
  }
  prior.covariance = variance * Eigen::Matrix3d::Identity();
  return std::string();
}

RotationAnswer GyroSource::measure(const PriorQuery& query) {
  RotationAnswer answer;
  RotationPrior prior;
  answer.problem = integrate(query, prior);
  if (!answer.problem.empty()) return answer;
  answer.prior = prior;
  const double readout = query.readout;
  if (readout == 0) return answer;
  const auto rateAt = [&](double stamp, Eigen::Vector3d& rate) {
    RotationPrior over_readout;
    std::string problem = integrate({query.camera_frame, stamp - 0.5 * readout, stamp + 0.5 * readout}, over_readout);
    if (problem.empty()) rate = rotationVector(over_readout.R) / readout;
    return problem;
  };
  RotationRates rates;
  answer.problem = rateAt(query.from, rates.reference);
  if (answer.problem.empty()) answer.problem = rateAt(query.to, rates.current);
  if (answer.problem.empty()) answer.prior->rates = rates;
  return answer;
}

void GyroSource::calibrate(const PriorQuery& query, const RotationPrior& visual) {
  TrackMotion rotation;
  Eigen::Isometry3d camera_in_imu;
  if (!gyro_.between(query, rotation, camera_in_imu).empty()) return;
  const Eigen::Matrix3d& axes = camera_in_imu.linear();
  std::lock_guard<std::mutex> lock(mutex_);
  bias_.add({query.from, query.to, axes * rotationVector(visual.R), rotationVector(rotation.motion.linear()),
             rotation.variance * Eigen::Matrix3d::Identity() + axes * visual.covariance * axes.transpose()});
}

void GyroSource::describe(PriorReport& report) {
  const GyroBias known = bias();
  const Eigen::Vector3d& rate = known.bias();
  report.values.emplace_back(
      "gyro bias (rad/s)", known.known() ? cv::format("(%.4f, %.4f, %.4f), standard deviation %.4f", rate.x(), rate.y(),
                                                      rate.z(), std::sqrt(known.variance()))
                                         : "unknown: the camera has not been at rest yet");
}

}  // namespace gms_ransac
