#include "matching/turn_prediction.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "gms_ransac/rays.h"

namespace gms_ransac {

namespace {

// Within a sixth of the image a turn of ten degrees bends a line by half a pixel.
constexpr int kColumns = 8, kRows = 6;
/// Half a window is so many standard deviations of the turn, and the parallax that is looked for as a share of the
/// square root of the image's area (doc/guided_search.md).
constexpr double kSigmas = 3, kParallax = 0.05;
/// A ray this far off the axis after the turn (the tangent) is out of any view that windows make sense in.
constexpr double kFarthest = 4;

/// Where the camera sees a pixel after the turn; none where that is out of view.
std::optional<cv::Point2f> turned(const Camera& camera, const Eigen::Matrix3d& to_current, const cv::Point2f& from) {
  const Eigen::Vector3d direction = to_current * rayOf(camera, from).homogeneous();
  const Eigen::Vector2d ray = direction.hnormalized();
  if (!(direction.z() > 0) || !(ray.norm() < kFarthest)) return std::nullopt;
  const cv::Point2f pixel = pixelOf(camera, ray);
  return std::isnan(pixel.x) ? std::nullopt : std::optional(pixel);
}

}  // namespace

void predictTurn(const RotationPrior& prior, const Camera& camera, MotionPrediction& prediction) {
  const cv::Size image = camera.imageSize();
  const cv::Point2f half(static_cast<float>(image.width) / (2 * kColumns),
                         static_cast<float>(image.height) / (2 * kRows));
  const auto parallax = static_cast<float>(kParallax * std::sqrt(static_cast<double>(image.area())));
  const Eigen::Matrix3d to_current = prior.R.transpose();
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
      const auto there = turned(camera, to_current, center),
                 right = turned(camera, to_current, center + cv::Point2f(half.x, 0)),
                 below = turned(camera, to_current, center + cv::Point2f(0, half.y));
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
