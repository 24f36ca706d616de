// The motion of a pair in the convention of estimators, which is the inverse of the public one (relative_pose.h).
#pragma once

#include <Eigen/Core>

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

struct PoseParameters;

/// X_current = R X_reference + t with |t| = 1.
struct TwoViewPose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitZ();

  Eigen::Matrix3d essential() const;
  PoseParameters parameters() const;
};

/// The public convention, without covariance.
inline RelativePose fromReferenceToCurrent(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  RelativePose pose;
  pose.R = R.transpose();
  pose.t = -(pose.R * t);
  return pose;
}

}  // namespace gms_ransac
