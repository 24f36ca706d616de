#include "stream/publishable_pose.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace gms_ransac {

namespace {

// Largest entry of R^T R - 1. Estimators leave rounding errors; a quaternion would hide larger ones.
constexpr double kRotationTolerance = 1e-9;
// Tolerance of mirrored entries, in standard deviations of both: after the inversion of an ill-conditioned matrix, and
// for publishing.
constexpr double kInversionTolerance = 1e-3;
constexpr double kSymmetryTolerance = 1e-9;

bool isRotation(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRotationTolerance &&
         R.determinant() > 0;
}

bool isSymmetric(const Eigen::Matrix<double, 6, 6>& covariance, double tolerance) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < i; ++j) {
      const double unit = std::sqrt(std::abs(covariance(i, i) * covariance(j, j)));
      if (std::abs(covariance(i, j) - covariance(j, i)) > tolerance * unit) return false;
    }
  }
  return true;
}

}  // namespace

void makePublishable(bool translation_known, const SigmaFloor& floor, RelativePose& pose) {
  if (!translation_known) {
    pose.t.setZero();
    setTranslationVariance(kUnknownTranslationVariance, pose.covariance);
  }
  // Adding the floor keeps the matrix positive definite; raising single entries would not.
  pose.covariance.diagonal().head<3>().array() += floor.translation * floor.translation * pose.t.squaredNorm();
  pose.covariance.diagonal().tail<3>().array() += floor.rotation * floor.rotation;
  // An invalid covariance stays as it is: bounded, it would look valid.
  const Eigen::Matrix<double, 6, 6>& covariance = pose.covariance;
  if (covariance.allFinite() && covariance.diagonal().minCoeff() >= 0 && isSymmetric(covariance, kInversionTolerance)) {
    boundCovariance(pose.covariance);
  }
}

std::string poseDefect(const RelativePose& pose) {
  if (!pose.t.allFinite()) return "its translation is not finite";
  if (!pose.R.allFinite()) return "its rotation is not finite";
  if (!isRotation(pose.R)) return "its rotation matrix is not a rotation";
  if (!pose.covariance.allFinite()) return "its covariance is not finite";
  if (!isSymmetric(pose.covariance, kSymmetryTolerance)) return "its covariance is not symmetric";
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> factors(pose.covariance);
  if (factors.info() != Eigen::Success) return "its covariance is not positive definite";
  return std::string();
}

void boundCovariance(Eigen::Matrix<double, 6, 6>& covariance) {
  if (!covariance.allFinite()) covariance = Eigen::Matrix<double, 6, 6>::Identity() * kLargestVariance;
  // Products and inverses are symmetric up to rounding only.
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
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
