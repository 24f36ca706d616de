#include "publishable_pose.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

RelativePose publishablePose(const RobustResult& robust, const SigmaFloor& floor) {
  RelativePose pose = robust.pose;
  if (!pose.covariance.allFinite()) pose.covariance.setIdentity() *= kLargestVariance;
  if (!robust.translation_observable) {
    pose.t.setZero();
    pose.covariance.topRows<3>().setZero();
    pose.covariance.leftCols<3>().setZero();
    pose.covariance.topLeftCorner<3, 3>().diagonal().setConstant(kLargestVariance);
  }
  // Adding the floor keeps the matrix positive definite; raising single entries would not.
  pose.covariance.diagonal().head<3>().array() += floor.translation * floor.translation;
  pose.covariance.diagonal().tail<3>().array() += floor.rotation * floor.rotation;
  boundCovariance(pose.covariance);
  return pose;
}

void boundCovariance(Eigen::Matrix<double, 6, 6>& covariance) {
  if (!covariance.allFinite()) covariance.setIdentity() *= kLargestVariance;
  for (int i = 0; i < 6; ++i) {
    const double variance = covariance(i, i);
    if (variance > kLargestVariance) {
      // Scaling a row and its column by the same factor keeps the matrix positive semi-definite.
      const double factor = std::sqrt(kLargestVariance / variance);
      covariance.row(i) *= factor;
      covariance.col(i) *= factor;
    }
    covariance(i, i) = std::clamp(covariance(i, i), kSmallestVariance, kLargestVariance);
  }
}

void applyScale(double length, double length_sigma, RelativePose& pose) {
  const Eigen::Vector3d direction = pose.t;
  pose.t *= length;
  pose.covariance.topRows<3>() *= length;
  pose.covariance.leftCols<3>() *= length;
  pose.covariance.topLeftCorner<3, 3>() += length_sigma * length_sigma * direction * direction.transpose();
  boundCovariance(pose.covariance);
}

}  // namespace gms_ransac
