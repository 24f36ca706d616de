#include "publishable_pose.h"

#include <algorithm>
#include <cmath>

namespace gms_ransac {

void makePublishable(bool translation_known, const SigmaFloor& floor, RelativePose& pose) {
  if (!pose.covariance.allFinite()) pose.covariance = Eigen::Matrix<double, 6, 6>::Identity() * kLargestVariance;
  if (!translation_known) {
    pose.t.setZero();
    pose.covariance.topRows<3>().setZero();
    pose.covariance.leftCols<3>().setZero();
    pose.covariance.topLeftCorner<3, 3>().diagonal().setConstant(kLargestVariance);
  }
  // Adding the floor keeps the matrix positive definite; raising single entries would not.
  pose.covariance.diagonal().head<3>().array() += floor.translation * floor.translation * pose.t.squaredNorm();
  pose.covariance.diagonal().tail<3>().array() += floor.rotation * floor.rotation;
  boundCovariance(pose.covariance);
}

void boundCovariance(Eigen::Matrix<double, 6, 6>& covariance) {
  if (!covariance.allFinite()) covariance = Eigen::Matrix<double, 6, 6>::Identity() * kLargestVariance;
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

}  // namespace gms_ransac
