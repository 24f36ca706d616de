#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

RelativePose fromReferenceToCurrent(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  RelativePose pose;
  pose.R = R.transpose();
  pose.t = -(pose.R * t);
  return pose;
}

}  // namespace gms_ransac
