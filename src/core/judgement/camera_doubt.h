// Whether the matches of a pair contradict the camera model, and by how much it may be off, as far as they tell.
// Derived in doc/uncertainty.md.
#pragma once

#include <Eigen/Core>

#include "gms_ransac/robust_estimator.h"
#include "judgement/residual_derivatives.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

using CameraParameters = Eigen::Matrix<double, Unmodelled::kCount, 1>;
using CameraSquare = Eigen::Matrix<double, Unmodelled::kCount, Unmodelled::kCount>;

/// What cameras in use are off by where they are: relative focal length, principal point in focal lengths, the first
/// coefficient of radial distortion, radians by a focal length's worth of rows.
const CameraParameters& unmodelledSigma();

/// Derivatives of the loss by the parameters of the camera model, less what a step of the pose explains of them.
struct CameraScores {
  CameraParameters score;
  CameraSquare information;  ///< of one parameter after the other, the second derivatives
  CameraSquare scatter;      ///< covariance of the score, from the cells
};

struct CameraContradiction {
  double statistic = 0;  ///< 1 is where chance alone would bring one pair in a hundred
  CameraParameter parameter = CameraParameter::kFocalLength;  ///< that is contradicted most
};

/// Rao's score test of each group of parameters.
CameraContradiction testCamera(const CameraScores& scores);

/// One step of Newton's from each error alone to the optimum, and how well it is known by the scatter.
CameraErrors cameraErrors(const CameraScores& scores, const TwoViewPose& pose);

/// Second moment of what the parameters are off by; zero where the matches do not contradict them.
CameraSquare cameraError(const CameraScores& scores);

}  // namespace gms_ransac
