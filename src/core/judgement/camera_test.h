// Tests if the matches of a pair contradict the camera model, and how far its errors may matter. Derived in
// doc/judgement.md.
#pragma once

#include <Eigen/Core>

#include "gms_ransac/robust_result.h"
#include "judgement/pose_information.h"

namespace gms_ransac {

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

}  // namespace gms_ransac
