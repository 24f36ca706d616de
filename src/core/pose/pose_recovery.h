// From a two-view model and its inliers to the relative pose, and whether the pair can tell it.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "gms_ransac/camera.h"
#include "gms_ransac/robust_estimator.h"
#include "robust/fast/point_columns.h"
#include "robust/fast/residual_kernels.h"

namespace gms_ransac {

/// The direction of translation is taken as measured when the displacement that no rotation explains exceeds this many
/// pixels in the median. Below it the direction is off by 17 degrees in the median and 40 in the upper quarter on
/// real sequences (doc/estimator.md).
constexpr double kObservableParallaxPx = 1.5;

class PoseRecovery {
 public:
  explicit PoseRecovery(SimdLevel level = detectSimdLevel()) : kernels_(&residualKernels(level)) {}
  /// Reads result.model, model_type and inlier; fills pose_found, pose, translation_observable and median_parallax_px.
  /// The pose of several that has most inliers in front of both cameras is taken. Nothing is filled when the camera is
  /// not calibrated. A homography of a pure rotation gives a zero translation.
  void recover(const PointPairs& pairs, const Camera& camera, double threshold_px, RobustResult& result);
  /// Moves an essential matrix and its pose to the robust optimum over the matches within twice the threshold. False,
  /// and nothing done, for another model or without a pose.
  bool refineEssential(const PointPairs& pairs, const Camera& camera, double threshold_px, RobustResult& result);

 private:
  /// A motion X_current = R X_reference + t.
  struct Motion {
    Eigen::Matrix3d R;
    Eigen::Vector3d t;
  };
  void collectInliers(const PointPairs& pairs, const Eigen::Matrix3d& K, const std::vector<uint8_t>& inlier);
  /// The collected points as the kernels read them; `threshold` on the normalised image plane.
  PointColumnsView fillColumns(double threshold);
  void proposeFromEssential(const Eigen::Matrix3d& E);
  void proposeFromHomography(const Eigen::Matrix3d& H, const Eigen::Matrix3d& K);
  /// Inliers that lie in front of both cameras.
  int countInFront(const Motion& motion) const;
  /// Sets the pose with its covariance, median_parallax_px and translation_observable; `unit_px`: mean focal length.
  void judgeParallax(const Motion& motion, double unit_px, double threshold_px, RobustResult& result);

  const ResidualKernels* kernels_;
  std::vector<Eigen::Vector3d> reference_, current_;  ///< matches on the normalised image plane (z = 1)
  std::vector<Motion> candidates_;
  PointColumns columns_;  ///< the same, as the kernels read them
  std::vector<float> all_inliers_, residuals_;
  std::vector<uint8_t> all_matches_;
};

}  // namespace gms_ransac
