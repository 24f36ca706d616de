#include "priors/rotation_source.h"

#include <utility>

#include "priors/odometry_input.h"
#include "priors/rotation_vectors.h"
#include "tf_lookup.h"

namespace gms_ransac {

namespace {

// Standard deviation of the rotation between two poses: a floor, radians, and a share of the rotation. The covariances
// of the poses do not give it, as they grow with the way from the start.
constexpr double kFloor = 0.005, kShare = 0.05;

RotationPrior priorOf(const Eigen::Matrix3d& R) {
  const double rotation = kShare * vectorOf(R).norm();
  RotationPrior prior;
  prior.R = R;
  prior.covariance.diagonal().setConstant(kFloor * kFloor + rotation * rotation);
  return prior;
}

}  // namespace

TfRotation::TfRotation(const std::string& fixed_frame, std::shared_ptr<TfLookup> tf)
    : fixed_frame_(fixed_frame), tf_(std::move(tf)) {}

bool TfRotation::reaches(const std::string& camera_frame, double stamp) {
  return tf_->knows(fixed_frame_, camera_frame, stamp);
}

std::string TfRotation::between(const std::string& camera_frame, double from, double to, RotationPrior& prior) {
  Eigen::Isometry3d start, end;
  std::string problem = tf_->get(fixed_frame_, camera_frame, from, start);
  if (problem.empty()) problem = tf_->get(fixed_frame_, camera_frame, to, end);
  if (problem.empty()) prior = priorOf(start.linear().transpose() * end.linear());
  return problem;
}

OdometryRotation::OdometryRotation(std::shared_ptr<OdometryInput> input) : input_(std::move(input)) {}

bool OdometryRotation::reaches(const std::string& /*camera_frame*/, double stamp) { return input_->reaches(stamp); }

std::string OdometryRotation::between(const std::string& camera_frame, double from, double to, RotationPrior& prior) {
  OdometryMotion motion;
  std::string problem = input_->between(camera_frame, from, to, motion);
  if (problem.empty()) prior = priorOf(motion.motion.linear());
  return problem;
}

}  // namespace gms_ransac
