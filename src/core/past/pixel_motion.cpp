#include "past/pixel_motion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "two_view/two_view_pose.h"

namespace gms_ransac {

namespace {

Eigen::Vector3d homogeneous(const cv::Point2f& p) { return {p.x, p.y, 1}; }

}  // namespace

PixelMotion::PixelMotion(const Camera& camera, const RelativePose& motion)
    : motion_(motion),
      to_ray_(camera.K().inverse()),
      to_reference_(camera.K() * motion.R * to_ray_),
      to_current_(camera.K() * motion.R.transpose() * to_ray_),
      // The motion leads from current to reference.
      F_(to_ray_.transpose() * TwoViewPose{motion.R, motion.t}.essential() * to_ray_) {}

Eigen::Vector2d PixelMotion::toCurrent(const cv::Point2f& p) const {
  return (to_current_ * homogeneous(p)).hnormalized();
}

Eigen::Vector2d PixelMotion::toReference(const cv::Point2f& q) const {
  return (to_reference_ * homogeneous(q)).hnormalized();
}

PixelMotion::Epipolar PixelMotion::epipolar(const cv::Point2f& p, const cv::Point2f& q) const {
  const Eigen::Vector3d line = F_ * homogeneous(q), line_of_current = F_.transpose() * homogeneous(p);
  return {homogeneous(p).dot(line), std::min(line.head<2>().norm(), line_of_current.head<2>().norm())};
}

double PixelMotion::fromLine(const cv::Point2f& p, const cv::Point2f& q) const {
  const Epipolar match = epipolar(p, q);
  return std::abs(match.product) / match.gradient;
}

double PixelMotion::fromLineSigma(const cv::Point2f& p, const cv::Point2f& q) const {
  const Eigen::Vector3d a = to_ray_ * homogeneous(p), b = motion_.R * (to_ray_ * homogeneous(q));
  Eigen::Matrix<double, 6, 1> derivative;  // of a . (t x b), by translation and rotation
  derivative << b.cross(a), b.cross(a.cross(motion_.t));
  return std::sqrt(derivative.dot(motion_.covariance * derivative)) / epipolar(p, q).gradient;
}

bool PixelMotion::isBehind(const cv::Point2f& p, const cv::Point2f& q) const {
  const Eigen::Vector3d a = to_ray_ * homogeneous(p), b = motion_.R * (to_ray_ * homogeneous(q)), normal = a.cross(b);
  return motion_.t.cross(b).dot(normal) < 0 || motion_.t.cross(a).dot(normal) < 0;
}

}  // namespace gms_ransac
