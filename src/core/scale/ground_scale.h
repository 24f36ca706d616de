// The length of the translation from the height of the camera above the ground it sees.
#pragma once

#include <string>

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

struct Ground {
  ScaleEstimate scale;  ///< of the translation; `features` 0: no ground was found
  std::string problem;  ///< why there is no length, as the end of a sentence; empty if there is one
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< in the current camera's frame, where there is a length
};

/// Fits the ground plane 1 / depth = m . (x, y, 1), m its normal over its distance, to inliers and image patches below
/// the horizon by robust least squares. A camera that keeps its height moves along the plane. `pose.t` of unit length.
Ground measureGround(const Triangulation& pair, const RelativePose& pose, const Camera& camera,
                     const GroundPrior& prior, const GroundImages& images = {});

}  // namespace gms_ransac
