#include "priors/motion_priors.h"

#include <algorithm>
#include <cmath>

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <opencv2/core.hpp>

#include "frames.h"
#include "tf_lookup.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

constexpr uint32_t kImuQueue = 1000, kOdometryQueue = 200;  // a second of a fast IMU, or of fast wheels
// Of extrinsics that were measured with a ruler, radians; and of the stamps of two drivers, seconds.
constexpr double kMountSigma = 0.01, kStampSigma = 0.002;
// Standard deviation of a length from wheels: a share of it, for their radius and the ground, and a tick, metres.
constexpr double kWheelShare = 0.03, kWheelTick = 0.001;
// Standard deviation of the direction down, radians: suspension of a robot if tf knows the camera on its base, else a
// camera held level.
constexpr double kSpringSigma = 0.02, kLevelSigma = 0.17;
// Standard deviation of the rotation between two poses: a floor, radians, and a share of the rotation. The covariances
// of the poses do not give it, as they grow with the way from the start.
constexpr double kPoseFloor = 0.005, kPoseShare = 0.05;

RotationPrior priorOf(const Eigen::Matrix3d& R) {
  const double rotation = kPoseShare * rotationVector(R).norm();
  RotationPrior prior;
  prior.R = R;
  prior.covariance.diagonal().setConstant(kPoseFloor * kPoseFloor + rotation * rotation);
  return prior;
}

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

std::shared_ptr<MotionPriors> MotionPriors::make(const ros::NodeHandle& nh, const Parameters& parameters) {
  return parameters.usesSensors() ? std::make_shared<MotionPriors>(nh, parameters) : nullptr;
}

MotionPriors::MotionPriors(const ros::NodeHandle& nh, const Parameters& parameters) : nh_(nh), parameters_(parameters) {
  const bool asks_tf = parameters.scale != ScaleMode::kGround || !parameters.base_frame.empty() ||
                       parameters.rotation_prior != RotationPriorKind::kNone;
  if (asks_tf) tf_ = std::make_unique<TfLookup>(nh);
  gyro_.topic = nh.resolveName("imu");
  wheels_.topic = nh.resolveName("prior_odom");
}

MotionPriors::MotionPriors(const Parameters& parameters) : parameters_(parameters) {}

MotionPriors::~MotionPriors() = default;

void MotionPriors::start(std::function<void()> arrived) {
  {
    std::lock_guard<std::mutex> lock(sensors_mutex_);
    gyro_.track.clear();
    wheels_.track.clear();
    gyro_.refused = wheels_.refused = 0;
  }
  const auto addRates = [this, arrived](const sensor_msgs::ImuConstPtr& imu) {
    {
      std::lock_guard<std::mutex> lock(sensors_mutex_);
      const auto& rate = imu->angular_velocity;
      const auto& covariance = imu->angular_velocity_covariance;
      gyro_.frame = parameters_.imu_frame.empty() ? withoutLeadingSlash(imu->header.frame_id) : parameters_.imu_frame;
      gyro_.defect = covariance[0] < 0 ? "no angular velocity (covariance -1); use an IMU with a gyro"  // by its .msg
                     : gyro_.frame.empty() ? "no frame_id; set ~imu_frame"
                                           : "";
      const double variance = std::max({0.0, covariance[0], covariance[4], covariance[8]});
      if (covariance[0] >= 0) {
        gyro_.note(gyro_.track.add(imu->header.stamp.toSec(), {rate.x, rate.y, rate.z}, variance));
      }
    }
    arrived();
  };
  const auto addPose = [this, arrived](const nav_msgs::OdometryConstPtr& odometry) {
    {
      std::lock_guard<std::mutex> lock(sensors_mutex_);
      wheels_.frame = withoutLeadingSlash(odometry->child_frame_id);
      wheels_.defect = wheels_.frame.empty() ? "no child_frame_id; set it to the frame that moves" : "";
      wheels_.note(wheels_.track.add(toSample(*odometry)));
    }
    arrived();
  };
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  if (byGyro()) {
    subscribers_.push_back(nh_->subscribe<sensor_msgs::Imu>("imu", kImuQueue, addRates, ros::VoidConstPtr(), hints));
  }
  if (byWheels()) {
    subscribers_.push_back(
        nh_->subscribe<nav_msgs::Odometry>("prior_odom", kOdometryQueue, addPose, ros::VoidConstPtr(), hints));
  }
}

void MotionPriors::stop() { subscribers_.clear(); }

bool MotionPriors::reaches(const std_msgs::Header& image) {
  const double stamp = timeOf(image);
  Eigen::Isometry3d unused;
  const bool by_tf = parameters_.rotation_prior == RotationPriorKind::kTf;
  if (by_tf && !tf_->get(parameters_.prior_frame, withoutLeadingSlash(image.frame_id), stamp, unused).empty()) {
    return false;
  }
  std::lock_guard<std::mutex> lock(sensors_mutex_);
  return (!byGyro() || gyro_.track.reaches(stamp + 0.5 * readout_)) && (!byWheels() || wheels_.track.reaches(stamp));
}

std::string MotionPriors::rotationBetween(const std::string& camera_frame, double from, double to,
                                          RotationPrior& prior) {
  if (byGyro()) return gyroBetween(camera_frame, from, to, prior);
  std::string problem;
  if (parameters_.rotation_prior == RotationPriorKind::kOdom) {
    TrackMotion odometry;
    problem = odometryBetween(camera_frame, from, to, odometry);
    prior = priorOf(odometry.motion.linear());
    return problem;
  }
  Eigen::Isometry3d start, end;
  problem = tf_->get(parameters_.prior_frame, camera_frame, from, start);
  if (problem.empty()) problem = tf_->get(parameters_.prior_frame, camera_frame, to, end);
  if (problem.empty()) prior = priorOf(start.linear().transpose() * end.linear());
  return problem;
}

template <typename Track>
std::string MotionPriors::sensorBetween(const Sensor<Track>& sensor, const std::string& camera_frame, double from,
                                        double to, TrackMotion& motion, Eigen::Isometry3d& camera_in_sensor) {
  if (!sensor.defect.empty()) return "the messages on " + sensor.topic + " have " + sensor.defect;
  const std::string problem = sensor.track.empty() ? "no message has come" : sensor.track.between(from, to, motion);
  if (!problem.empty() && sensor.refused > 0) {
    return "the last " + std::to_string(sensor.refused) + " messages on " + sensor.topic +
           " are not used: their numbers are not finite, or larger than any sensor's";
  }
  if (!problem.empty()) return problem + " on " + sensor.topic;
  // Both are screwed to one body: the latest is as good as any.
  return tf_->get(sensor.frame, camera_frame, 0, camera_in_sensor);
}

std::string MotionPriors::gyroBetween(const std::string& camera_frame, double from, double to, RotationPrior& prior) {
  std::lock_guard<std::mutex> lock(sensors_mutex_);
  TrackMotion rotation, earlier;
  Eigen::Isometry3d camera_in_imu;
  std::string problem = sensorBetween(gyro_, camera_frame, from, to, rotation, camera_in_imu);
  if (!problem.empty()) return problem;
  const double seconds = to - from;
  const Eigen::Matrix3d less_bias = rotationFromVector(-0.5 * seconds * bias_.bias());
  prior.R =
      camera_in_imu.linear().transpose() * less_bias * rotation.motion.linear() * less_bias * camera_in_imu.linear();
  const double mount = kMountSigma * rotationVector(prior.R).norm();
  double variance = rotation.variance + seconds * seconds * bias_.variance() + mount * mount;
  // The change if the stamps were late by their standard deviation.
  if (gyro_.track.between(from - kStampSigma, to - kStampSigma, earlier).empty()) {
    variance += rotationVector(rotation.motion.linear().transpose() * earlier.motion.linear()).squaredNorm();
  }
  prior.covariance = variance * Eigen::Matrix3d::Identity();
  return std::string();
}

std::string MotionPriors::odometryBetween(const std::string& camera_frame, double from, double to,
                                          TrackMotion& motion) {
  std::lock_guard<std::mutex> lock(sensors_mutex_);
  Eigen::Isometry3d camera_in_body;
  std::string problem = sensorBetween(wheels_, camera_frame, from, to, motion, camera_in_body);
  if (problem.empty()) motion.motion = camera_in_body.inverse() * motion.motion * camera_in_body;
  return problem;
}

std::optional<RotationPrior> MotionPriors::rotation(const std_msgs::Header& reference, const std_msgs::Header& current,
                                                    std::string& problem) {
  problem.clear();
  asked_ = {current.frame_id, timeOf(reference), timeOf(current), std::nullopt};
  if (parameters_.rotation_prior == RotationPriorKind::kNone) return std::nullopt;
  RotationPrior prior;
  if (!(asked_.from < asked_.to)) {
    problem = "the reference is not before the current image";
  } else {
    problem = rotationBetween(asked_.camera_frame, asked_.from, asked_.to, prior);
  }
  if (problem.empty()) {
    problem = fillRates(prior);
    asked_.prior = prior;
  } else {
    problem = "no rotation prior: " + problem;
  }
  std::lock_guard<std::mutex> lock(mutex_);
  problem_ = problem;
  camera_frame_ = current.frame_id;
  return asked_.prior;
}

std::string MotionPriors::fillRates(RotationPrior& prior) {
  const double readout = readout_;
  if (readout == 0 || !byGyro()) return std::string();
  const auto rateAt = [&](double stamp, Eigen::Vector3d& rate) {
    RotationPrior over_readout;
    std::string problem = gyroBetween(asked_.camera_frame, stamp - 0.5 * readout, stamp + 0.5 * readout, over_readout);
    if (problem.empty()) rate = rotationVector(over_readout.R) / readout;
    return problem;
  };
  RotationRates rates;
  std::string problem = rateAt(asked_.from, rates.reference);
  if (problem.empty()) problem = rateAt(asked_.to, rates.current);
  if (!problem.empty()) return "no rotation during the readout: " + problem;
  prior.rates = rates;
  return std::string();
}

void MotionPriors::learn(const RobustResult& seen) {
  if (!asked_.prior) return;
  RotationPrior visual;
  visual.R = seen.pose.R;
  visual.covariance = seen.pose.covariance.bottomRightCorner<3, 3>();
  if (byGyro()) learnBias(visual);
  std::lock_guard<std::mutex> lock(mutex_);
  pairs_by_rates_ += seen.row_correction == RowCorrection::kPrior;
  comparison_.add({asked_.from, asked_.to, rotationVector(visual.R), rotationVector(asked_.prior->R),
                   visual.covariance + asked_.prior->covariance});
}

void MotionPriors::learnBias(const RotationPrior& visual) {
  std::lock_guard<std::mutex> lock(sensors_mutex_);
  TrackMotion rotation;
  Eigen::Isometry3d camera_in_imu;
  if (!sensorBetween(gyro_, asked_.camera_frame, asked_.from, asked_.to, rotation, camera_in_imu).empty()) return;
  const Eigen::Matrix3d& axes = camera_in_imu.linear();
  bias_.add({asked_.from, asked_.to, axes * rotationVector(visual.R), rotationVector(rotation.motion.linear()),
             rotation.variance * Eigen::Matrix3d::Identity() + axes * visual.covariance * axes.transpose()});
}

ScaleEstimate MotionPriors::length(const PairSeen& pair, std::string& problem) {
  ScaleEstimate estimate;
  problem.clear();
  if (parameters_.scale == ScaleMode::kOdometry) {
    estimate =
        lengthOfOdometry(pair.current.frame_id, timeOf(pair.reference), timeOf(pair.current), pair.seen, problem);
  } else if (pair.seen.translation_observable) {
    const Ground ground =
        measureGround(pair.points, pair.seen.pose, pair.camera, groundPrior(pair.current.frame_id), pair.images);
    estimate = ground.scale;
    problem = ground.problem;
  }
  std::lock_guard<std::mutex> lock(mutex_);
  length_problem_ = problem;
  return estimate;
}

ScaleEstimate MotionPriors::lengthOfOdometry(const std::string& camera_frame, double from, double to,
                                             const RobustResult& seen, std::string& problem) {
  TrackMotion odometry;
  problem =
      from < to ? odometryBetween(camera_frame, from, to, odometry) : "the reference is not before the current image";
  if (problem.empty()) problem = wheel_check_.judge(odometry.motion.translation(), seen);
  ScaleEstimate estimate;
  if (!problem.empty()) return estimate;
  estimate.length = odometry.motion.translation().norm();
  const double seconds = to - from, share = kWheelShare * estimate.length;
  const double variance = std::max(share * share, odometry.variance * seconds);
  estimate.relative_sigma = std::sqrt(variance + kWheelTick * kWheelTick) / std::max(estimate.length, kWheelTick);
  estimate.features = 1;
  return estimate;
}

GroundPrior MotionPriors::groundPrior(const std::string& camera_frame) {
  GroundPrior prior;
  prior.camera_height = parameters_.camera_height;
  prior.down_sigma = kLevelSigma;
  Eigen::Isometry3d base_in_camera;
  if (!parameters_.base_frame.empty() && tf_->get(camera_frame, parameters_.base_frame, 0, base_in_camera).empty()) {
    prior.down = -base_in_camera.linear().col(2);
    prior.down_sigma = kSpringSigma;
  }
  return prior;
}

PriorReport MotionPriors::report() {
  RotationComparison comparison;
  std::string camera_frame;
  int pairs_by_rates = 0;
  PriorReport report;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    comparison = comparison_;
    camera_frame = camera_frame_;
    pairs_by_rates = pairs_by_rates_;
    report.summary = problem_;
    if (report.summary.empty() && !length_problem_.empty()) report.summary = "no length: " + length_problem_;
  }
  report.doubtful = !report.summary.empty();
  if (report.summary.empty()) report.summary = comparison.agreement();
  if (parameters_.rotation_prior == RotationPriorKind::kNone) return report;
  const auto between = [&](double from, double to) -> std::optional<Eigen::Vector3d> {
    RotationPrior prior;
    if (!rotationBetween(camera_frame, from, to, prior).empty()) return std::nullopt;
    return rotationVector(prior.R);
  };
  const std::optional<TimeOffset> offset = comparison.timeOffset(between);
  const std::string doubt = comparison.doubt(offset);
  if (!doubt.empty()) {
    report.summary = doubt;
    report.doubtful = true;
  }
  const auto add = [&](const char* key, const std::string& value) { report.values.emplace_back(key, value); };
  if (byGyro()) {
    std::lock_guard<std::mutex> lock(sensors_mutex_);
    const Eigen::Vector3d& bias = bias_.bias();
    add("gyro bias (rad/s)", bias_.known() ? cv::format("(%.4f, %.4f, %.4f), standard deviation %.4f", bias.x(),
                                                        bias.y(), bias.z(), std::sqrt(bias_.variance()))
                                           : "unknown: the camera has not been at rest yet");
  }
  add("pairs compared", std::to_string(comparison.pairs()));
  if (readout_ > 0) add("pairs corrected for readout", std::to_string(pairs_by_rates));
  add("contradicting", std::to_string(std::lround(100 * comparison.contradicting())) + " %");
  add("~image_time_offset (s)", offset ? cv::format("%.4f, standard deviation %.4f",
                                                    parameters_.image_time_offset + offset->seconds, offset->sigma)
                                       : "unknown: too little rotation");
  return report;
}

}  // namespace gms_ransac
