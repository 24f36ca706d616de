// Four-point homography in closed form, through the projective basis of each quadrangle.
#pragma once

#include <Eigen/Core>

namespace gms_ransac {

/// x1, x2: four correspondences in any units. Writes H with x2 ~ H x1, of unit Frobenius norm, and returns 1; 0 if
/// three of the points are collinear (or two equal) in either image.
int solveHomography4(const double (&x1)[4][2], const double (&x2)[4][2], Eigen::Matrix3d models[1]);

}  // namespace gms_ransac
