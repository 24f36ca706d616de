#include "scenes/scene_imu.h"

#include <cmath>

#include <opencv2/core.hpp>

#include "support/validation.h"

namespace gms_ransac {

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kDifference = 2e-4;  // seconds

/// Sample of the ideal IMU at a time, between two poses close to it.
ImuSample idealSample(const std::function<Isometry3d(double)>& imu_pose, double time) {
  const Isometry3d before = imu_pose(time - kDifference), now = imu_pose(time), after = imu_pose(time + kDifference);
  const Eigen::AngleAxisd rotation(before.linear().transpose() * after.linear());
  const Vector3d acceleration =
      (after.translation() - 2 * now.translation() + before.translation()) / (kDifference * kDifference);
  return {time, rotation.angle() / (2 * kDifference) * rotation.axis(),
          now.linear().transpose() * (acceleration + kGravity * Vector3d::UnitZ())};
}

}  // namespace

void ImuOptions::validate() const {
  requireInRange("imu rate", rate, 0.0, 10000.0);
  requireInRange("gyro_noise", gyro_noise, 0.0, 1.0);
  requireInRange("accelerometer_noise", accelerometer_noise, 0.0, 10.0);
  requireInRange("gyro_walk", gyro_walk, 0.0, 1.0);
  requireInRange("accelerometer_walk", accelerometer_walk, 0.0, 10.0);
  requireInRange("imu delay", delay, -1.0, 1.0);
}

std::vector<ImuSample> simulateImu(const std::function<Isometry3d(double)>& camera_pose, double from, double to,
                                   const ImuOptions& options, uint64_t seed) {
  const Isometry3d imu_in_camera = options.camera_in_imu.inverse();
  const auto imu_pose = [&](double time) { return camera_pose(time) * imu_in_camera; };
  cv::RNG rng(seed + 1);
  const auto noise = [&rng](double sigma) -> Vector3d {
    const double x = rng.gaussian(sigma), y = rng.gaussian(sigma), z = rng.gaussian(sigma);
    return {x, y, z};
  };
  const double root = std::sqrt(options.rate);  // density times it: deviation of a sample; walk over it: a step
  Vector3d gyro_bias = Vector3d::Zero(), accelerometer_bias = Vector3d::Zero();
  std::vector<ImuSample> samples;
  for (int i = 0; from + i / options.rate <= to; ++i) {
    ImuSample sample = idealSample(imu_pose, from + i / options.rate);
    sample.time += options.delay;
    sample.angular_velocity += gyro_bias + noise(options.gyro_noise * root);
    sample.specific_force += accelerometer_bias + noise(options.accelerometer_noise * root);
    gyro_bias += noise(options.gyro_walk / root);
    accelerometer_bias += noise(options.accelerometer_walk / root);
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace gms_ransac
