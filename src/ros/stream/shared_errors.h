// Errors that all motions of a stream have in common, as those of a calibration: they do not average out along the way.
#pragma once

#include <Eigen/Core>

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

/// One standard deviation of each independent error, a column each: its covariance is the matrix times its transpose.
/// Rows as in RelativePose::covariance; the last columns are those of two cameras or of a depth camera
/// (DepthEstimate::by_sensor).
constexpr int kSensorErrors = 4;
using SharedErrors = Eigen::Matrix<double, 6, 16 + kSensorErrors>;

/// Errors of one motion, linear in it, so that they cancel on the way back. A wrong calibration changes displacements
/// in the image by a share of themselves, those by the rotation and those by the translation. Each makes an error of
/// the rotation, and of the translation at the distance of the scene: `share` of it in each axis. `parallax`:
/// displacement in the image by the translation, radians.
SharedErrors sharedErrors(double share, const RelativePose& motion, double parallax);

/// Those of c in a, of b in a, whose rotation is R, and c in b, which is at t.
SharedErrors chained(const SharedErrors& b_in_a, const Eigen::Matrix3d& R, const SharedErrors& c_in_b,
                     const Eigen::Vector3d& t);

}  // namespace gms_ransac
