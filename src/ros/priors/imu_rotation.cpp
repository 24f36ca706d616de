#include "priors/imu_rotation.h"

#include <algorithm>
#include <utility>

#include <opencv2/core.hpp>

#include "frames.h"
#include "priors/rotation_vectors.h"
#include "tf_lookup.h"

namespace gms_ransac {

namespace {

constexpr uint32_t kImuQueue = 1000;  // a second of a fast IMU
// Of extrinsics that were measured with a ruler, radians; and of the stamps of two drivers, seconds.
constexpr double kMountSigma = 0.01, kStampSigma = 0.002;

}  // namespace

ImuRotation::ImuRotation(const ros::NodeHandle& nh, const std::string& imu_frame, std::shared_ptr<TfLookup> tf,
                         std::function<void()> arrived)
    : nh_(nh), given_frame_(imu_frame), tf_(std::move(tf)), arrived_(std::move(arrived)) {}

void ImuRotation::start() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    gyro_.clear();
  }
  subscriber_ = nh_.subscribe("imu", kImuQueue, &ImuRotation::onImu, this, ros::TransportHints().tcpNoDelay());
}

void ImuRotation::onImu(const sensor_msgs::ImuConstPtr& imu) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    frame_ = given_frame_.empty() ? withoutLeadingSlash(imu->header.frame_id) : given_frame_;
    no_gyro_ = imu->angular_velocity_covariance[0] < 0;  // sensor_msgs/Imu: -1 marks an IMU without a gyro
    const auto& rate = imu->angular_velocity;
    const auto& covariance = imu->angular_velocity_covariance;
    if (!no_gyro_) {
      gyro_.add({imu->header.stamp.toSec(),
                 {rate.x, rate.y, rate.z},
                 std::max({covariance[0], covariance[4], covariance[8]})});
    }
  }
  arrived_();
}

bool ImuRotation::reaches(double stamp) {
  std::lock_guard<std::mutex> lock(mutex_);
  return gyro_.reaches(stamp);
}

std::string ImuRotation::extrinsics(const std::string& camera_frame, Eigen::Matrix3d& imu_in_camera) {
  if (frame_.empty()) return "the messages on " + nh_.resolveName("imu") + " have no frame_id; set ~imu_frame";
  Eigen::Isometry3d transform;
  // Both are screwed to one body: the latest is as good as any.
  std::string problem = tf_->get(camera_frame, frame_, 0, transform);
  imu_in_camera = transform.linear();
  return problem;
}

std::string ImuRotation::between(const std::string& camera_frame, double from, double to, RotationPrior& prior) {
  std::lock_guard<std::mutex> lock(mutex_);
  const std::string topic = nh_.resolveName("imu");
  if (no_gyro_) return "the messages on " + topic + " have no angular velocity (covariance -1); use an IMU with a gyro";
  if (gyro_.empty()) return "no sample has come on " + topic;
  GyroRotation rotation;
  std::string problem = gyro_.integrate(from, to, bias_.bias(), rotation);
  if (!problem.empty()) return problem + " on " + topic;
  Eigen::Matrix3d imu_in_camera;
  problem = extrinsics(camera_frame, imu_in_camera);
  if (!problem.empty()) return problem;
  prior.R = imu_in_camera * rotation.R * imu_in_camera.transpose();
  const double seconds = to - from;
  prior.covariance =
      imu_in_camera * (rotation.covariance + seconds * seconds * bias_.covariance()) * imu_in_camera.transpose();
  const double mount = kMountSigma * vectorOf(rotation.R).norm(), late = kStampSigma * rotation.rate_change;
  prior.covariance.diagonal().array() += mount * mount + late * late;
  return std::string();
}

void ImuRotation::learn(const std::string& camera_frame, double from, double to, const RotationPrior& visual) {
  std::lock_guard<std::mutex> lock(mutex_);
  GyroRotation rotation;
  Eigen::Matrix3d imu_in_camera;
  if (!gyro_.integrate(from, to, Eigen::Vector3d::Zero(), rotation).empty()) return;
  if (!extrinsics(camera_frame, imu_in_camera).empty()) return;
  const Eigen::Matrix3d camera_in_imu = imu_in_camera.transpose();
  bias_.add({from, to, camera_in_imu * vectorOf(visual.R), vectorOf(rotation.R),
             rotation.covariance + camera_in_imu * visual.covariance * imu_in_camera});
}

std::string ImuRotation::learnt() {
  std::lock_guard<std::mutex> lock(mutex_);
  if (!bias_.known()) return "gyro bias unknown: the camera has not been at rest yet";
  const Eigen::Vector3d sigma = bias_.covariance().diagonal().cwiseSqrt();
  return cv::format("gyro bias (%.4f, %.4f, %.4f) rad/s, standard deviation (%.4f, %.4f, %.4f)", bias_.bias().x(),
                    bias_.bias().y(), bias_.bias().z(), sigma.x(), sigma.y(), sigma.z());
}

}  // namespace gms_ransac
