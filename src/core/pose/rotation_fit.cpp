#include "pose/rotation_fit.h"

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace gms_ransac {

namespace {

constexpr int kRefits = 4;  ///< the median residual stops falling after three on the synthetic scenes of the tests

/// `correlation`: sum of current * reference^T over unit rays.
Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& correlation) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Eigen::Matrix3d fitRotation(const std::vector<Eigen::Vector3d>& reference, const std::vector<Eigen::Vector3d>& current,
                            std::vector<double>& workspace) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  double limit = std::numeric_limits<double>::infinity();
  for (int refit = 0; refit <= kRefits && !reference.empty(); ++refit) {
    Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
    for (size_t i = 0; i < reference.size(); ++i) {
      const double residual = ((R * reference[i]).hnormalized() - current[i].hnormalized()).norm();
      if (residual <= limit) correlation += current[i].normalized() * reference[i].normalized().transpose();
    }
    R = nearestRotation(correlation);
    rotationResiduals(R, reference, current, workspace);
    limit = medianInPlace(workspace);
  }
  return R;
}

void rotationResiduals(const Eigen::Matrix3d& R, const std::vector<Eigen::Vector3d>& reference,
                       const std::vector<Eigen::Vector3d>& current, std::vector<double>& residuals) {
  residuals.clear();
  for (size_t i = 0; i < reference.size(); ++i) {
    residuals.push_back(((R * reference[i]).hnormalized() - current[i].hnormalized()).norm());
  }
}

double medianInPlace(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace gms_ransac
