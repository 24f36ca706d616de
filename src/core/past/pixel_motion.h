// A motion as pixels of the ideal camera see it: places that its rotation predicts, epipolar lines, points behind a
// camera.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

/// A match agrees with a motion up to this distance from its epipolar lines, pixels.
constexpr double kOnLine = 4;

/// `p` is a point of the reference image, `q` one of the current image, undistorted.
class PixelMotion {
 public:
  PixelMotion(const Camera& camera, const RelativePose& motion);

  /// The place of `p` in the current image, and of `q` in the reference image, by the rotation alone.
  Eigen::Vector2d toCurrent(const cv::Point2f& p) const;
  Eigen::Vector2d toReference(const cv::Point2f& q) const;
  /// The larger of the distances of a match from its two epipolar lines, pixels.
  double fromLine(const cv::Point2f& p, const cv::Point2f& q) const;
  /// Standard deviation of `fromLine` by the covariance of the motion: errors of rotation and translation that do not
  /// move the line do not count.
  double fromLineSigma(const cv::Point2f& p, const cv::Point2f& q) const;
  /// True if the point of a match is behind a camera.
  bool isBehind(const cv::Point2f& p, const cv::Point2f& q) const;

 private:
  /// p . F q, and what makes of it the distance from the line.
  struct Epipolar {
    double product, gradient;
  };
  Epipolar epipolar(const cv::Point2f& p, const cv::Point2f& q) const;

  RelativePose motion_;
  Eigen::Matrix3d to_ray_, to_reference_, to_current_, F_;
};

}  // namespace gms_ransac
