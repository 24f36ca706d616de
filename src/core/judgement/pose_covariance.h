// How well the matches determine a pose: one covariance, and what other steps ask of it. Derived in doc/judgement.md.
#pragma once

#include <Eigen/Core>

#include "judgement/camera_test.h"
#include "judgement/pose_information.h"

namespace gms_ransac {

/// First-order uncertainty of a pose in the parameters of PoseModel::linearize.
struct PoseCovariance {
  PoseSquare covariance = PoseSquare::Identity();  ///< what is published
  PoseSquare of_matches = PoseSquare::Identity();  ///< its part that assumes a perfect camera
  /// Naive sandwich covariance: no correction for noise as parallax or leverage. The preferred rotation is weighed
  /// against it, because a wider one would follow the preference further than errors do.
  PoseSquare naive = PoseSquare::Identity();
  /// Standard deviation of the direction of translation, radians, if nothing were known of the camera but that it has
  /// no more than the typical calibration errors.
  double direction_sigma_any_camera = 1;
  CameraTest camera;
};

/// `sigma`: of the noise, thresholds; `calibration_sigma`: RobustOptions::calibration_sigma. Identity where the matches
/// do not suffice.
PoseCovariance poseCovariance(const PoseInformation& information, double sigma, double calibration_sigma);

/// Standard deviation of the direction of translation along its widest axis, radians.
double directionSigma(const PoseSquare& covariance);

/// The covariance in the project's convention (see RelativePose).
Eigen::Matrix<double, 6, 6> relativeCovariance(const TwoViewPose& pose, const PoseSquare& covariance);

}  // namespace gms_ransac
