// The motion between two images in metres: robust least squares over the motion and the points that both show.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

/// A point in one image: x, y on the plane z = 1 and inverse depth, 1/m. In these the motion and its noise are nearly
/// linear, out to infinity.
struct SeenPoint {
  Eigen::Vector3d value, variance;
  bool has_depth;
  double row;  ///< -0.5 at the top of the image, 0.5 at the bottom
};

/// Depth in the frame of `pose` of a point that is seen at its end; 0: not known.
double depthIn(const RelativePose& pose, const Eigen::Vector3d& seen);

struct JointPoint {
  SeenPoint reference, current;
  Eigen::Vector3d estimate = Eigen::Vector3d::Zero();  ///< of `reference.value`, by all measurements
  int freedom = 1;  ///< of its residual: 1 without depth (the Sampson distance), 2 with depth in one image, 3 in both
  int32_t cell = 0;

  /// Estimate and freedom before the refinement. `depth`: in the reference where neither image shows it; 0: not known.
  void begin(const RelativePose& pose, double depth);
};

/// Motion, and what a sensor adds to it.
struct JointMotion {
  RelativePose pose;  ///< of the middle rows
  bool two_cameras;
  /// Errors of the inverse depths that calibration leaves, to be added to each measured one. Two cameras: 1/m, and its
  /// growth with x (focal lengths that differ), y (a camera rolled against the other) and x^2 + y^2 (yawed against it,
  /// or undistorted around a wrong centre). A depth camera: the last is in 1/m; a factor would be one of the
  /// translation. Its first three are a rotation vector, current minus reference, from the top row to the bottom. If
  /// the rotation during the readout of a rolling shutter differs between the images, the difference grows with the
  /// row; without it in the model it would be taken for translation.
  Eigen::Vector4d sensor = Eigen::Vector4d::Zero();
};

/// JointMotion::sensor as it is known before.
struct SensorPrior {
  Eigen::Vector4d mean;
  Eigen::Matrix4d information;  ///< inverse of the covariance
  int shared_from;              ///< the errors from here on are the same in all pairs; not correlated with the others
};

/// JointMotion::sensor by the points alone, without the prior.
struct SensorEvidence {
  Eigen::Vector4d score;        ///< information times the likeliest one
  Eigen::Matrix4d information;  ///< by the scatter of the parts of the image
};

struct JointEstimate {
  RelativePose pose;  ///< without the errors of the prior that all pairs share in the covariance
  /// These errors of the pose: a column each of independent ones of one standard deviation; 0 up to `shared_from`.
  Eigen::Matrix<double, 6, 4> shared;
  SensorEvidence sensor;
};

/// Moves `start` to the least cost, and the estimates of the points. `close`: the start is known to a deviation or two.
/// None where there is no solution.
std::optional<JointEstimate> refineJointly(std::vector<JointPoint>& points, const JointMotion& start,
                                           const SensorPrior& prior, bool close);

}  // namespace gms_ransac
