#include "priors/motion_priors.h"

#include <cmath>

#include <ros/node_handle.h>
#include <opencv2/core.hpp>

#include "frames.h"
#include "priors/ground_source.h"
#include "priors/gyro_source.h"
#include "priors/tf_source.h"
#include "priors/wheel_source.h"
#include "tf_lookup.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

std::shared_ptr<MotionPriors> MotionPriors::make(const ros::NodeHandle& nh, const Parameters& parameters) {
  return parameters.usesSensors() ? std::make_shared<MotionPriors>(nh, parameters) : nullptr;
}

MotionPriors::MotionPriors(const ros::NodeHandle& nh, const Parameters& parameters)
    : image_time_offset_(parameters.image_time_offset) {
  const RotationPriorKind kind = parameters.rotation_prior;
  const bool asks_tf =
      parameters.scale != ScaleMode::kGround || !parameters.base_frame.empty() || kind != RotationPriorKind::kNone;
  if (asks_tf) tf_ = std::make_unique<TfLookup>(nh);
  std::shared_ptr<WheelTrack> wheels;
  if (kind == RotationPriorKind::kOdom || parameters.scale == ScaleMode::kOdometry) {
    wheels = std::make_shared<WheelTrack>(nh, *tf_);
  }
  if (kind == RotationPriorKind::kImu) {
    rotation_ = gyro_ = std::make_shared<GyroSource>(nh, parameters.imu_frame, *tf_);
  } else if (kind == RotationPriorKind::kTf) {
    rotation_ = std::make_shared<TfSource>(parameters.prior_frame, *tf_);
  } else if (kind == RotationPriorKind::kOdom) {
    rotation_ = std::make_shared<WheelRotation>(wheels);
  }
  if (parameters.scale == ScaleMode::kOdometry) {
    length_ = std::make_shared<WheelLength>(wheels);
  } else if (parameters.scale == ScaleMode::kGround) {
    length_ = std::make_shared<GroundSource>(parameters.camera_height, parameters.base_frame, tf_.get());
  }
}

MotionPriors::MotionPriors(const Parameters& parameters)
    : image_time_offset_(parameters.image_time_offset),
      length_(std::make_shared<GroundSource>(parameters.camera_height, parameters.base_frame, nullptr)) {}

MotionPriors::~MotionPriors() = default;

void MotionPriors::start(const std::function<void()>& arrived) {
  if (rotation_) rotation_->start(arrived);
  if (length_) length_->start(arrived);
}

void MotionPriors::stop() {
  if (rotation_) rotation_->stop();
  if (length_) length_->stop();
}

void MotionPriors::setReadout(double seconds) {
  readout_ = seconds;
  if (gyro_) gyro_->setReadout(seconds);
}

bool MotionPriors::reaches(const std_msgs::Header& image) {
  const std::string frame = withoutLeadingSlash(image.frame_id);
  const double stamp = image.stamp.toSec() + image_time_offset_;
  return (!rotation_ || rotation_->reaches(frame, stamp)) && (!length_ || length_->reaches(frame, stamp));
}

PriorQuery MotionPriors::queryOf(const std_msgs::Header& reference, const std_msgs::Header& current) const {
  return {current.frame_id, reference.stamp.toSec() + image_time_offset_, current.stamp.toSec() + image_time_offset_};
}

AskedRotation MotionPriors::rotation(const std_msgs::Header& reference, const std_msgs::Header& current) {
  AskedRotation asked = {queryOf(reference, current), std::nullopt, std::string()};
  if (!rotation_) return asked;
  RotationPrior prior;
  asked.problem = asked.query.from < asked.query.to ? rotation_->ask(asked.query, prior)
                                                    : "the reference is not before the current image";
  if (asked.problem.empty()) {
    asked.problem = rotation_->askRates(asked.query, prior);
    asked.prior = prior;
  } else {
    asked.problem = "no rotation prior: " + asked.problem;
  }
  std::lock_guard<std::mutex> lock(mutex_);
  problem_ = asked.problem;
  camera_frame_ = current.frame_id;
  return asked;
}

void MotionPriors::compare(const AskedRotation& asked, const RobustResult& seen) {
  if (!asked.prior) return;
  RotationPrior visual;
  visual.R = seen.pose.R;
  visual.covariance = seen.pose.covariance.bottomRightCorner<3, 3>();
  rotation_->compare(asked.query, visual);
  std::lock_guard<std::mutex> lock(mutex_);
  pairs_by_rates_ += seen.row_correction == RowCorrection::kPrior;
  comparison_.add({asked.query.from, asked.query.to, rotationVector(visual.R), rotationVector(asked.prior->R),
                   visual.covariance + asked.prior->covariance});
}

ScaleEstimate MotionPriors::length(const std_msgs::Header& reference, const std_msgs::Header& current,
                                   const PairSeen& pair, std::string& problem) {
  problem.clear();
  if (!length_) return ScaleEstimate();
  const ScaleEstimate estimate = length_->ask(queryOf(reference, current), pair, problem);
  std::lock_guard<std::mutex> lock(mutex_);
  length_problem_ = problem;
  return estimate;
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
  if (!rotation_) return report;
  const auto between = [&](double from, double to) -> std::optional<Eigen::Vector3d> {
    RotationPrior prior;
    if (!rotation_->ask({camera_frame, from, to}, prior).empty()) return std::nullopt;
    return rotationVector(prior.R);
  };
  const std::optional<TimeOffset> offset = comparison.timeOffset(between);
  const std::string doubt = comparison.doubt(offset);
  if (!doubt.empty()) {
    report.summary = doubt;
    report.doubtful = true;
  }
  rotation_->report(report);
  const auto add = [&](const char* key, const std::string& value) { report.values.emplace_back(key, value); };
  add("pairs compared", std::to_string(comparison.pairs()));
  if (readout_ > 0) add("pairs corrected for readout", std::to_string(pairs_by_rates));
  add("contradicting", std::to_string(std::lround(100 * comparison.contradicting())) + " %");
  add("~image_time_offset (s)",
      offset ? cv::format("%.4f, standard deviation %.4f", image_time_offset_ + offset->seconds, offset->sigma)
             : "unknown: too little rotation");
  return report;
}

}  // namespace gms_ransac
