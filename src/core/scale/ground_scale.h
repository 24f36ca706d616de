// The length of the translation from the height of the camera above the ground it sees.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/relative_pose.h"
#include "gms_ransac/triangulation.h"
#include "scale/translation_scale.h"

namespace gms_ransac {

/// Prior of the ground.
struct GroundPrior {
  double camera_height = 0;                         ///< metres, > 0, in both images
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();  ///< unit, normal of the ground in the current camera's frame
  double down_sigma = 0.17;                         ///< radians about any axis: ten degrees of a camera held level
};

/// The two images, CV_8UC1, in which a ground without corners is to be found; empty: in none.
struct GroundImages {
  cv::Mat reference, current;
};

/// Normal equations of the three numbers of a plane, in units of the noise that the patches have.
struct PlaneEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  /// Sum of the patches' gradients squared: what samples of one patch, which err together, leave of H's promise.
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  int patches = 0;  ///< that agree
};

/// Patches of the image below the horizon, compared with the other image through a plane m: points X of the current
/// camera's frame with m . X = 1, lengths in multiples of |t|.
class GroundPatches {
 public:
  /// Patches of the current image whose rays dip below the horizon of `down` by that sine and more.
  void set(const GroundImages& images, const Camera& camera, const RelativePose& pose, const Eigen::Vector3d& down,
           double smallest_dip);
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

/// Fits the ground plane 1 / depth = m . (x, y, 1), m its normal over its distance, to inliers and image patches below
/// the horizon by robust least squares. A camera that keeps its height moves along the plane.
class GroundScale {
 public:
  /// Length of the translation of this pair, `pose.t` of unit length. `features` 0: no ground found, see problem().
  ScaleEstimate measure(const Triangulation& pair, const RelativePose& pose, const Camera& camera,
                        const GroundPrior& prior, const GroundImages& images = {});
  /// Why the last pair has no length, as the end of a sentence; empty if it has one.
  const std::string& problem() const { return problem_; }
  /// Normal of the ground in the current camera's frame, from the last pair with a length.
  const Eigen::Vector3d& normal() const { return normal_; }

 private:
  struct Point {
    Eigen::Vector3d ray;  ///< (x, y, 1) in the current image
    double inverse_depth, sigma;
  };
  struct Fit {
    Eigen::Vector3d m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double points = 0;  ///< sum of their weights
    int patches = 0;
  };
  void gather(const Triangulation& pair, const RelativePose& pose, double pixel, const GroundPrior& prior);
  /// The plane of one point and the prior's normal with the most support; zero: none.
  Eigen::Vector3d startFromPoints(const GroundPrior& prior) const;
  /// The plane with the prior's normal through which the images agree best; zero: none.
  Eigen::Vector3d startFromPatches(const GroundPrior& prior) const;
  Fit fit(Eigen::Vector3d m, const Eigen::Vector3d& t, const GroundPrior& prior) const;
  /// Why the fit is no ground; empty if it is.
  std::string doubt(const Fit& fit, const GroundPrior& prior) const;

  std::vector<Point> points_;
  GroundPatches patches_;
  std::string problem_;
  Eigen::Vector3d normal_ = Eigen::Vector3d::UnitY();
};

}  // namespace gms_ransac
