#include "matching/turn_prediction.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>

namespace gms_ransac {

namespace {

// Within a sixth of the image a turn of ten degrees bends a line by half a pixel.
constexpr int kColumns = 8, kRows = 6;
/// Half a window is so many standard deviations of the turn, and the parallax that is looked for as a share of the
/// square root of the image's area (doc/guided_search.md).
constexpr double kSigmas = 3, kParallax = 0.05;
/// A ray this far off the axis after the turn (the tangent) is out of any view that windows make sense in.
constexpr double kFarthest = 4;

Eigen::Vector3d rayOf(const Camera& camera, const cv::Point2f& pixel) {
  const CameraIntrinsics& k = camera.intrinsics();
  const cv::Point2f ideal = camera.undistort(pixel);
  return {(ideal.x - k.cx) / k.fx, (ideal.y - k.cy) / k.fy, 1};
}

/// The pixel that shows the ray; none where it is out of view.
std::optional<cv::Point2f> pixelOf(const Camera& camera, const Eigen::Vector3d& ray) {
  const double x = ray.x() / ray.z(), y = ray.y() / ray.z();
  if (!(ray.z() > 0) || !(std::hypot(x, y) < kFarthest)) return std::nullopt;
  const CameraIntrinsics& k = camera.intrinsics();
  const cv::Point2f pixel = camera.distort({static_cast<float>(k.fx * x + k.cx), static_cast<float>(k.fy * y + k.cy)});
  return std::isnan(pixel.x) ? std::nullopt : std::optional(pixel);
}

}  // namespace

void predictTurn(const RotationPrior& prior, const Camera& camera, MotionPrediction& prediction) {
  const cv::Size image = camera.imageSize();
  const cv::Point2f half(static_cast<float>(image.width) / (2 * kColumns),
                         static_cast<float>(image.height) / (2 * kRows));
  const auto parallax = static_cast<float>(kParallax * std::sqrt(static_cast<double>(image.area())));
  const Eigen::Matrix3d to_current = prior.R.transpose();
  const auto turned = [&](const cv::Point2f& pixel) { return pixelOf(camera, to_current * rayOf(camera, pixel)); };
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(prior.covariance, Eigen::EigenvaluesOnly);
  const double sigma = std::sqrt(std::max(axes.eigenvalues().maxCoeff(), 0.0));
  const auto reach = static_cast<float>(kSigmas * sigma * camera.meanFocalLength());
  prediction.columns = kColumns;
  prediction.rows = kRows;
  prediction.cells.assign(static_cast<size_t>(kColumns) * kRows, CellMotion());
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      CellMotion& motion = prediction.cells[static_cast<size_t>(row) * kColumns + column];
      const cv::Point2f center(static_cast<float>(2 * column + 1) * half.x, static_cast<float>(2 * row + 1) * half.y);
      const auto there = turned(center), right = turned(center + cv::Point2f(half.x, 0)),
                 below = turned(center + cv::Point2f(0, half.y));
      if (!there || !right || !below) continue;
      motion.known = true;
      motion.center = center;
      motion.displacement = *there - center;
      motion.per_x = (*right - *there) / half.x - cv::Point2f(1, 0);
      motion.per_y = (*below - *there) / half.y - cv::Point2f(0, 1);
      motion.reach = {parallax + reach, parallax + reach};
    }
  }
}

}  // namespace gms_ransac
