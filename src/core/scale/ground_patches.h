// Patches of the image below the horizon, compared with the other image through the plane that they may lie on. A road
// has hardly a corner, and texture all the same.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

/// Normal equations of the three numbers of a plane, in units of the noise that the patches have.
struct PlaneEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  /// Sum of the patches' gradients squared: what samples of one patch, which err together, leave of H's promise.
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  int patches = 0;  ///< that agree
};

/// A plane m: points X of the current camera's frame with m . X = 1, lengths in multiples of |t|.
class GroundPatches {
 public:
  /// Patches of `current` whose rays dip below the horizon of `down` by that sine and more. CV_8UC1 both.
  void set(const cv::Mat& reference, const cv::Mat& current, const Camera& camera, const RelativePose& pose,
           const Eigen::Vector3d& down, double smallest_dip);
  int size() const { return static_cast<int>(patches_.size()); }
  /// Sum over some of the patches, by every few of their samples, of how well they correlate beyond chance.
  double score(const Eigen::Vector3d& m) const;
  PlaneEquations linearize(const Eigen::Vector3d& m) const;

 private:
  static constexpr int kSide = 9, kSamples = kSide * kSide;
  struct Patch {
    Eigen::Matrix<float, 3, kSamples> rays;    ///< (x, y, 1)
    Eigen::Matrix<float, kSamples, 1> values;  ///< grey levels, mean 0 and norm 1
  };
  bool cut(const cv::Mat& image, const Camera& camera, int x, int y, Patch& patch) const;
  /// Grey level and its gradient by the normalised image plane, where the reference shows a point of the plane; false
  /// outside.
  bool look(const Eigen::Vector3d& m, const Eigen::Vector3d& ray, float& value, Eigen::RowVector3d* derivative) const;
  cv::Point2f toReceived(const cv::Point2f& ideal) const;

  cv::Mat reference_, current_;  ///< smoothed
  Camera camera_;
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_ = Eigen::Vector3d::Zero();
  std::vector<Patch> patches_;
};

}  // namespace gms_ransac
