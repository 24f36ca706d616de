#include "priors/motion_priors.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

#include "frames.h"
#include "priors/imu_rotation.h"
#include "priors/odometry_input.h"
#include "priors/rotation_vectors.h"
#include "tf_lookup.h"

namespace gms_ransac {

namespace {

// Standard deviation of a length from wheels: a share of it, for their radius and the ground, and a tick, metres.
constexpr double kWheelShare = 0.03, kWheelTick = 0.001;
// Standard deviation of the direction down, radians: suspension of a robot if tf knows the camera on its base, else a
// camera held level.
constexpr double kSpringSigma = 0.02, kLevelSigma = 0.17;
// Standard deviation of the rotation between two poses: a floor, radians, and a share of the rotation. The covariances
// of the poses do not give it, as they grow with the way from the start.
constexpr double kPoseFloor = 0.005, kPoseShare = 0.05;

RotationPrior priorOf(const Eigen::Matrix3d& R) {
  const double rotation = kPoseShare * vectorOf(R).norm();
  RotationPrior prior;
  prior.R = R;
  prior.covariance.diagonal().setConstant(kPoseFloor * kPoseFloor + rotation * rotation);
  return prior;
}

}  // namespace

std::shared_ptr<MotionPriors> MotionPriors::make(const ros::NodeHandle& nh, const Parameters& parameters) {
  const bool wanted = parameters.rotation_prior != RotationPriorKind::kNone ||
                      parameters.scale == ScaleMode::kOdometry || parameters.scale == ScaleMode::kGround;
  return wanted ? std::make_shared<MotionPriors>(nh, parameters) : nullptr;
}

MotionPriors::MotionPriors(const ros::NodeHandle& nh, const Parameters& parameters) : parameters_(parameters) {
  const RotationPriorKind kind = parameters.rotation_prior;
  const bool asks_tf =
      parameters.scale != ScaleMode::kGround || !parameters.base_frame.empty() || kind != RotationPriorKind::kNone;
  if (asks_tf) tf_ = std::make_shared<TfLookup>(nh);
  const auto arrived = [this] { arrived_(); };
  if (parameters.scale == ScaleMode::kOdometry || kind == RotationPriorKind::kOdom) {
    odometry_ = std::make_unique<OdometryInput>(nh, tf_, arrived);
  }
  if (kind == RotationPriorKind::kImu) imu_ = std::make_unique<ImuRotation>(nh, parameters.imu_frame, tf_, arrived);
}

MotionPriors::~MotionPriors() = default;

void MotionPriors::start(std::function<void()> arrived) {
  arrived_ = std::move(arrived);
  if (odometry_) odometry_->start();
  if (imu_) imu_->start();
}

void MotionPriors::stop() {
  if (odometry_) odometry_->stop();
  if (imu_) imu_->stop();
}

bool MotionPriors::reaches(const std_msgs::Header& image) {
  const double stamp = timeOf(image);
  if (imu_ && !imu_->reaches(stamp + 0.5 * readout_)) return false;
  Eigen::Isometry3d unused;
  const bool by_tf = parameters_.rotation_prior == RotationPriorKind::kTf;
  if (by_tf && !tf_->get(parameters_.prior_frame, withoutLeadingSlash(image.frame_id), stamp, unused).empty()) {
    return false;
  }
  return !odometry_ || odometry_->reaches(stamp);
}

std::string MotionPriors::rotationBetween(const std::string& camera_frame, double from, double to,
                                          RotationPrior& prior) {
  if (imu_) return imu_->between(camera_frame, from, to, prior);
  std::string problem;
  if (parameters_.rotation_prior == RotationPriorKind::kOdom) {
    OdometryMotion odometry;
    problem = odometry_->between(camera_frame, from, to, odometry);
    prior = priorOf(odometry.motion.linear());
    return problem;
  }
  Eigen::Isometry3d start, end;
  problem = tf_->get(parameters_.prior_frame, camera_frame, from, start);
  if (problem.empty()) problem = tf_->get(parameters_.prior_frame, camera_frame, to, end);
  if (problem.empty()) prior = priorOf(start.linear().transpose() * end.linear());
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
  if (readout == 0 || !imu_) return std::string();
  const auto rateAt = [&](double stamp, Eigen::Vector3d& rate) {
    RotationPrior over_readout;
    std::string problem =
        imu_->between(asked_.camera_frame, stamp - 0.5 * readout, stamp + 0.5 * readout, over_readout);
    if (problem.empty()) rate = vectorOf(over_readout.R) / readout;
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
  if (imu_) imu_->learn(asked_.camera_frame, asked_.from, asked_.to, visual);
  std::lock_guard<std::mutex> lock(mutex_);
  pairs_by_rates_ += seen.row_correction == RowCorrection::kPrior;
  comparison_.add({asked_.from, asked_.to, vectorOf(visual.R), vectorOf(asked_.prior->R),
                   visual.covariance + asked_.prior->covariance});
}

ScaleEstimate MotionPriors::length(const PairSeen& pair, std::string& problem) {
  ScaleEstimate estimate;
  problem.clear();
  if (parameters_.scale == ScaleMode::kOdometry) {
    estimate =
        lengthOfOdometry(pair.current.frame_id, timeOf(pair.reference), timeOf(pair.current), pair.seen, problem);
  } else if (pair.seen.translation_observable) {
    estimate =
        ground_.measure(pair.points, pair.seen.pose, pair.camera, groundPrior(pair.current.frame_id), pair.images);
    problem = ground_.problem();
  }
  std::lock_guard<std::mutex> lock(mutex_);
  length_problem_ = problem;
  return estimate;
}

ScaleEstimate MotionPriors::lengthOfOdometry(const std::string& camera_frame, double from, double to,
                                             const RobustResult& seen, std::string& problem) {
  OdometryMotion odometry;
  problem = from < to ? odometry_->between(camera_frame, from, to, odometry)
                      : "the reference is not before the current image";
  if (problem.empty()) problem = wheels_.problem(odometry.motion.translation(), seen);
  ScaleEstimate estimate;
  if (!problem.empty()) return estimate;
  estimate.length = odometry.motion.translation().norm();
  const double seconds = to - from, share = kWheelShare * estimate.length;
  const double variance = std::max(share * share, odometry.velocity_variance * seconds * seconds);
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
  if (report.summary.empty())
    report.summary = comparison.pairs() > 0 ? "agrees with the images" : "nothing compared yet";
  if (parameters_.rotation_prior == RotationPriorKind::kNone) return report;
  const auto between = [&](double from, double to) -> std::optional<Eigen::Vector3d> {
    RotationPrior prior;
    if (!rotationBetween(camera_frame, from, to, prior).empty()) return std::nullopt;
    return vectorOf(prior.R);
  };
  const std::optional<TimeOffset> offset = comparison.timeOffset(between);
  const std::string doubt = comparison.doubt(offset);
  if (!doubt.empty()) {
    report.summary = doubt;
    report.doubtful = true;
  }
  if (imu_) report.values.emplace_back("learnt", imu_->learnt());
  report.values.emplace_back("pairs compared", std::to_string(comparison.pairs()));
  if (readout_ > 0) report.values.emplace_back("pairs corrected for readout", std::to_string(pairs_by_rates));
  report.values.emplace_back("contradicting", std::to_string(std::lround(100 * comparison.contradicting())) + " %");
  report.values.emplace_back("~image_time_offset (s)",
                             offset ? cv::format("%.4f, standard deviation %.4f",
                                                 parameters_.image_time_offset + offset->seconds, offset->sigma)
                                    : "unknown: too little rotation");
  return report;
}

}  // namespace gms_ransac
