// From a two-view model and its inliers to the relative pose, and whether the pair can tell it.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "gms_ransac/camera.h"
#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

/// The direction of translation is taken as measured when the displacement that no rotation explains exceeds this many
/// pixels in the median.
constexpr double kObservableParallaxPx = 1.0;

class PoseRecovery {
 public:
  /// Reads result.model, model_type and inlier; fills pose_found, pose, translation_observable and median_parallax_px.
  /// The pose of several that has most inliers in front of both cameras is taken. Nothing is filled when the camera is
  /// not calibrated. A homography of a pure rotation gives a zero translation.
  void recover(const PointPairs& pairs, const Camera& camera, RobustResult& result);

 private:
  /// A motion X_current = R X_reference + t.
  struct Motion {
    Eigen::Matrix3d R;
    Eigen::Vector3d t;
  };
  void collectInliers(const PointPairs& pairs, const Eigen::Matrix3d& K, const std::vector<uint8_t>& inlier);
  void proposeFromEssential(const Eigen::Matrix3d& E);
  void proposeFromHomography(const Eigen::Matrix3d& H, const Eigen::Matrix3d& K);
  /// Inliers that lie in front of both cameras.
  int countInFront(const Motion& motion) const;
  /// Sets median_parallax_px and translation_observable; the rotation too where it is all that can be told.
  void judgeParallax(double focal_length, RobustResult& result);

  std::vector<Eigen::Vector3d> reference_, current_;  ///< inliers on the normalised image plane (z = 1)
  std::vector<Motion> candidates_;
  std::vector<double> residuals_;
};

}  // namespace gms_ransac
