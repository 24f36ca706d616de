// Pixels of the received image and rays of the camera, there and back.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "gms_ransac/camera.h"

namespace gms_ransac {

/// (x, y) of the ray (x, y, 1) of a pixel of the received image, of a calibrated camera; NaN where Camera::undistort
/// has none.
inline Eigen::Vector2d rayOf(const Camera& camera, const cv::Point2f& pixel) {
  const CameraIntrinsics& k = camera.intrinsics();
  const cv::Point2f ideal = camera.undistort(pixel);
  return {(ideal.x - k.cx) / k.fx, (ideal.y - k.cy) / k.fy};
}

/// The reverse; NaN where Camera::distort has none.
inline cv::Point2f pixelOf(const Camera& camera, const Eigen::Vector2d& ray) {
  const CameraIntrinsics& k = camera.intrinsics();
  return camera.distort({static_cast<float>(k.fx * ray.x() + k.cx), static_cast<float>(k.fy * ray.y() + k.cy)});
}

}  // namespace gms_ransac
