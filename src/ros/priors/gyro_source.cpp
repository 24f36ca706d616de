#include "priors/gyro_source.h"

#include <algorithm>

#include <sensor_msgs/Imu.h>

#include "frames.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

constexpr uint32_t kImuQueue = 1000;  // a second of a fast IMU
constexpr double kBiasSigma = 0.05;   // rad/s: three degrees a second, a cheap MEMS gyro's zero-rate offset

}  // namespace

GyroSource::GyroSource(const ros::NodeHandle& nh, const Parameters& parameters, TfLookup& tf)
    : RotationSource(nh.resolveName("imu"), parameters.image_time_offset, kBiasSigma),
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

std::string GyroSource::integrate(const PriorQuery& query, RotationPrior& prior) const {
  TrackMotion rotation;
  Eigen::Isometry3d camera_in_imu;
  std::string problem = gyro_.between(query, rotation, camera_in_imu);
  if (!problem.empty()) return problem;
  prior.R = camera_in_imu.linear().transpose() * rotation.motion.linear() * camera_in_imu.linear();
  prior.covariance = rotation.variance * Eigen::Matrix3d::Identity();
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

}  // namespace gms_ransac
