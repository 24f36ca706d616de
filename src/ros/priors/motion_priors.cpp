#include "priors/motion_priors.h"

#include <ros/node_handle.h>

#include "frames.h"
#include "priors/ground_source.h"
#include "priors/gyro_source.h"
#include "priors/tf_source.h"
#include "priors/wheel_source.h"
#include "tf_lookup.h"

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
  std::shared_ptr<WheelRotation> wheels;
  if (kind == RotationPriorKind::kOdom || parameters.scale == ScaleMode::kOdometry) {
    wheels = std::make_shared<WheelRotation>(nh, parameters, *tf_);
  }
  if (kind == RotationPriorKind::kImu) {
    rotation_ = std::make_unique<GyroSource>(nh, parameters, *tf_);
  } else if (kind == RotationPriorKind::kTf) {
    rotation_ = std::make_unique<TfSource>(parameters, *tf_);
  } else if (kind == RotationPriorKind::kOdom) {
    rotation_ = wheels;
  }
  if (parameters.scale == ScaleMode::kOdometry) {
    length_ = std::make_unique<WheelLength>(wheels, rotation_ != wheels);
  } else if (parameters.scale == ScaleMode::kGround) {
    length_ = std::make_unique<GroundSource>(parameters, tf_.get());
  }
}

MotionPriors::MotionPriors(const Parameters& parameters)
    : image_time_offset_(parameters.image_time_offset), length_(std::make_unique<GroundSource>(parameters, nullptr)) {}

MotionPriors::~MotionPriors() = default;

void MotionPriors::start(const std::function<void()>& arrived) {
  if (rotation_) rotation_->start(arrived);
  if (length_) length_->start(arrived);
}

void MotionPriors::stop() {
  if (rotation_) rotation_->stop();
  if (length_) length_->stop();
}

bool MotionPriors::reaches(const std_msgs::Header& image) const {
  PriorQuery at_image = query(image, image);
  at_image.camera_frame = withoutLeadingSlash(at_image.camera_frame);
  return (!rotation_ || rotation_->reaches(at_image)) && (!length_ || length_->reaches(at_image));
}

PriorQuery MotionPriors::query(const std_msgs::Header& reference, const std_msgs::Header& current) const {
  return {current.frame_id, reference.stamp.toSec() + image_time_offset_, current.stamp.toSec() + image_time_offset_,
          readout_};
}

PriorReport MotionPriors::report() const {
  if (!rotation_) return length_->report();
  PriorReport report = rotation_->report();
  const PriorReport of_length = length_ ? length_->report() : PriorReport();
  report.found.insert(report.found.end(), of_length.found.begin(), of_length.found.end());
  if (report.doubtful || !of_length.doubtful) return report;
  report.doubtful = true;
  report.summary = of_length.summary;
  return report;
}

}  // namespace gms_ransac
