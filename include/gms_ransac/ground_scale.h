// The length of the translation from the height of the camera above the ground it sees.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/relative_pose.h"
#include "gms_ransac/translation_scale.h"
#include "gms_ransac/triangulation.h"

namespace gms_ransac {

/// What is known of the ground before it is seen.
struct GroundPrior {
  double camera_height = 0;                         ///< metres, > 0, in both images
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();  ///< unit, normal of the ground in the current camera's frame
  double down_sigma = 0.17;                         ///< radians about any axis: ten degrees of a camera held level
};

/// The two images, CV_8UC1, where a ground without corners is to be found in them.
struct GroundImages {
  cv::Mat reference, current;
};

class GroundPatches;

/// The ground is a plane, on which inverse depth is linear over the image: 1 / depth = m . (x, y, 1), with m its normal
/// over its distance. m is fitted to the inliers below the horizon, each weighed by its parallax, and to patches of the
/// images below it, by robust least squares. As the camera keeps its height it moves along the plane, which tells the
/// normal better than a few points do.
class GroundScale {
 public:
  GroundScale();
  ~GroundScale();

  /// Length of the translation of this pair, `pose.t` of unit length. Without images the inliers alone count.
  /// `features` 0: no ground was found, and problem() says why.
  ScaleEstimate measure(const Triangulation& pair, const RelativePose& pose, const Camera& camera,
                        const GroundPrior& prior, const GroundImages& images = {});
  /// Why the last pair has no length, as the end of a sentence; empty: it has one.
  const std::string& problem() const { return problem_; }
  /// Of the last pair that has a length: normal of the ground in the current camera's frame.
  const Eigen::Vector3d& normal() const { return normal_; }

 private:
  /// A point below the horizon.
  struct Point {
    Eigen::Vector3d ray;  ///< (x, y, 1) in the current image
    double inverse_depth, sigma;
  };
  /// A plane, and what supports it.
  struct Fit {
    Eigen::Vector3d m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double points = 0;  ///< sum of their weights
    int patches = 0;
  };
  void gather(const Triangulation& pair, const RelativePose& pose, double pixel, const GroundPrior& prior);
  /// The plane of one point and the prior's normal that most points support; zero: none.
  Eigen::Vector3d startFromPoints(const GroundPrior& prior) const;
  /// The plane with the prior's normal through which the images agree best; zero: none.
  Eigen::Vector3d startFromPatches(const GroundPrior& prior) const;
  Fit fit(Eigen::Vector3d m, const Eigen::Vector3d& t, const GroundPrior& prior) const;
  /// Why the fit is no ground; empty: it is one.
  std::string doubt(const Fit& fit, const GroundPrior& prior) const;

  std::vector<Point> points_;
  std::unique_ptr<GroundPatches> patches_;
  std::string problem_;
  Eigen::Vector3d normal_ = Eigen::Vector3d::UnitY();
};

}  // namespace gms_ransac
