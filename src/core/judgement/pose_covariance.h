// How well the matches determine a pose: one covariance, and what other steps ask of it; errors of the camera. Derived
// in doc/judgement.md.
#pragma once

#include <Eigen/Core>

#include "gms_ransac/robust_result.h"
#include "judgement/pose_information.h"

namespace gms_ransac {

/// How far the matches contradict the camera model, and how far its errors may matter.
struct CameraTest {
  /// Largest score statistic over the 99 % point of its chi-square.
  double statistic = 0;
  CameraParameter parameter = CameraParameter::kFocalLength;  ///< the most contradicted
  /// Second moment of the parameters' errors, averaged over models of which parameters err; zero where the matches do
  /// not contradict them.
  CameraSquare second_moment = CameraSquare::Zero();
};

/// `inverse`: of the curvature by the pose, with noise counted as parallax: with the camera free, the direction is too
/// uncertain for the correction.
CameraTest testCamera(const PoseInformation& information, const PoseSquare& inverse);

/// First-order uncertainty of a pose in the parameters of PoseModel::linearize.
struct PoseCovariance {
  PoseSquare covariance = PoseSquare::Identity();  ///< what is published
  PoseSquare of_matches = PoseSquare::Identity();  ///< its part that assumes a perfect camera
  /// Naive sandwich covariance: no correction for noise as parallax or leverage. The preferred rotation is weighed
  /// against it, because a wider one would follow the preference further than errors do.
  PoseSquare naive = PoseSquare::Identity();
  CameraTest camera;
};

/// `variance`: of the noise, squared thresholds; `calibration_sigma`: RobustOptions::calibration_sigma. Identity where
/// the matches do not suffice.
PoseCovariance poseCovariance(const PoseInformation& information, double variance, double calibration_sigma);
/// Naive sandwich covariance if nothing were known of the camera but that it has no more than the typical calibration
/// errors. Identity where the matches do not suffice.
PoseSquare covarianceOfAnyCamera(const PoseInformation& information, double variance);

/// Standard deviation of the direction of translation along its widest axis, radians.
double directionSigma(const PoseSquare& covariance);

/// The covariance in the project's convention (see RelativePose).
Eigen::Matrix<double, 6, 6> relativeCovariance(const TwoViewPose& pose, const PoseSquare& covariance);

}  // namespace gms_ransac
