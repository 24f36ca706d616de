#include "priors/tf_source.h"

#include "tf_lookup.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

// Standard deviation of the rotation between two poses: a floor, radians, and a share of the rotation.
constexpr double kPoseFloor = 0.005, kPoseShare = 0.05;

}  // namespace

RotationPrior priorOfPoses(const Eigen::Matrix3d& R) {
  const double rotation = kPoseShare * rotationVector(R).norm();
  RotationPrior prior;
  prior.R = R;
  prior.covariance.diagonal().setConstant(kPoseFloor * kPoseFloor + rotation * rotation);
  return prior;
}

bool TfSource::reaches(const std::string& camera_frame, double stamp) {
  Eigen::Isometry3d unused;
  return tf_.get(fixed_frame_, camera_frame, stamp, unused).empty();
}

std::string TfSource::ask(const PriorQuery& query, RotationPrior& prior) {
  Eigen::Isometry3d start, end;
  std::string problem = tf_.get(fixed_frame_, query.camera_frame, query.from, start);
  if (problem.empty()) problem = tf_.get(fixed_frame_, query.camera_frame, query.to, end);
  if (problem.empty()) prior = priorOfPoses(start.linear().transpose() * end.linear());
  return problem;
}

}  // namespace gms_ransac
