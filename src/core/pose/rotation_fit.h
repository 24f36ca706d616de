// The rotation that explains correspondences best without any translation.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace gms_ransac {

/// R with current ~ R reference (points of the normalised image plane, z = 1; as many of both), the least squares
/// solution on unit rays (Kabsch 1976), refitted a few times to the half that agrees best, since near points of a
/// translating camera do not. Identity when there are none.
Eigen::Matrix3d fitRotation(const std::vector<Eigen::Vector3d>& reference, const std::vector<Eigen::Vector3d>& current,
                            std::vector<double>& workspace);

/// Distance on the normalised image plane between R reference and current, for each correspondence.
void rotationResiduals(const Eigen::Matrix3d& R, const std::vector<Eigen::Vector3d>& reference,
                       const std::vector<Eigen::Vector3d>& current, std::vector<double>& residuals);

/// The middle element of the upper half on even counts, 0 of none. Reorders the values.
double medianInPlace(std::vector<double>& values);

}  // namespace gms_ransac
