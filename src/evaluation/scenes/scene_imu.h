// The IMU that a rendered camera carries: what a gyroscope and an accelerometer measure along its path.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Geometry>

namespace gms_ransac {

/// The noise is by default that of EuRoC's ADIS16448.
struct ImuOptions {
  double rate = 0;                    ///< samples per second; 0: no IMU
  double gyro_noise = 1.7e-4;         ///< density of the white noise, rad/s/sqrt(Hz)
  double accelerometer_noise = 2e-3;  ///< m/s^2/sqrt(Hz)
  double gyro_walk = 1.9e-5;          ///< random walk of the bias, rad/s^2/sqrt(Hz)
  double accelerometer_walk = 3e-3;   ///< m/s^3/sqrt(Hz)
  double delay = 0;                   ///< seconds by which the stamps are later than the measurements
  Eigen::Isometry3d camera_in_imu = Eigen::Isometry3d::Identity();  ///< X_imu = camera_in_imu * X_camera

  /// Throws std::invalid_argument with a sentence that names the field, its value and its range.
  void validate() const;
};

struct ImuSample {
  double time;                       ///< seconds, with the delay
  Eigen::Vector3d angular_velocity;  ///< rad/s in the IMU's axes
  Eigen::Vector3d specific_force;    ///< m/s^2 in the IMU's axes; at rest kGravity upwards
};

constexpr double kGravity = 9.81;  ///< m/s^2 along -z of the world

/// Samples from time `from` to `to`, seconds, of an IMU on a camera with these poses, X_world = camera_pose * X_camera.
/// Biases start at 0. Derivatives are differences over 0.4 ms: exact to 1e-4 for motion of hands, vehicles and drones.
std::vector<ImuSample> simulateImu(const std::function<Eigen::Isometry3d(double)>& camera_pose, double from, double to,
                                   const ImuOptions& options, uint64_t seed);

}  // namespace gms_ransac
