#include "gms/motion_prediction.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

// Within a sixth of the image a rotation of ten degrees bends a line by half a pixel.
constexpr int kColumns = 8, kRows = 6;
/// Half a window in standard deviations of the rotation; parallax as a share of the square root of the image's area.
constexpr double kSigmas = 3, kParallax = 0.05;
/// Tangent of the angle to the axis beyond which a rotated ray counts as out of view.
constexpr double kFarthest = 4;

std::optional<cv::Point2f> rotated(const Camera& camera, const Eigen::Matrix3d& to_current, const cv::Point2f& from) {
  const Eigen::Vector3d direction = to_current * rayOf(camera, from).homogeneous();
  const Eigen::Vector2d ray = direction.hnormalized();
  if (!(direction.z() > 0) || !(ray.norm() < kFarthest)) return std::nullopt;
  const cv::Point2f pixel = pixelOf(camera, ray);
  return std::isnan(pixel.x) ? std::nullopt : std::optional(pixel);
}

}  // namespace

void predictRotation(const RotationPrior& prior, const Camera& camera, MotionPrediction& prediction) {
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
      const auto there = rotated(camera, to_current, center),
                 right = rotated(camera, to_current, center + cv::Point2f(half.x, 0)),
                 below = rotated(camera, to_current, center + cv::Point2f(0, half.y));
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

namespace {

// Chosen on kitti_06 (gaps 1, 5), tum_fr1_desk (1, 4) and tum_fr1_rpy (5), doc/inside/guided_search.md.

/// Share of accepted matches below which none is believed: unrelated images have at most 0.10.
constexpr double kLeastAccepted = 0.15;
/// Accepted matches, and their share, that a cell with one and with two rings of neighbours needs.
constexpr double kLeastMatches = 6;
constexpr double kLeastShare[] = {0.3, 0.2};
constexpr int kRings = 2;

/// Fits, each without the matches that the one before leaves more than kOutlierSigmas away.
constexpr int kPasses = 2;
constexpr double kOutlierSigmas = 2.5;
/// Half a window in standard deviations about the fit, and its margin as a share of the square root of the image's
/// area.
constexpr double kReachSigmas = 2;
constexpr double kMargin = 0.005;

}  // namespace

const MotionPrediction& MotionPredictor::predict(const Features& reference, const Features& current,
                                                 const std::vector<Match>& matches,
                                                 const MotionStatistics& statistics) {
  const cv::Size image = reference.image_size;
  prediction_.cells.clear();
  if (statistics.accepted_count < kLeastAccepted * static_cast<double>(matches.size())) return prediction_;
  prediction_.columns = statistics.grid_columns;
  prediction_.rows = statistics.grid_rows;
  const size_t cells = static_cast<size_t>(prediction_.columns) * prediction_.rows;
  prediction_.cells.assign(cells, CellMotion());
  cell_ = {static_cast<double>(image.width) / prediction_.columns,
           static_cast<double>(image.height) / prediction_.rows};
  margin_ = static_cast<float>(kMargin * std::sqrt(static_cast<double>(image.area())));
  all_.assign(cells, 0);
  for (const int32_t cell : statistics.cell) ++all_[static_cast<size_t>(cell)];
  for (int pass = 0; pass < kPasses; ++pass) {
    collect(reference, current, matches, statistics);
    for (int row = 0; row < prediction_.rows; ++row) {
      for (int column = 0; column < prediction_.columns; ++column) {
        CellMotion& motion = prediction_.cells[static_cast<size_t>(row) * prediction_.columns + column];
        motion.known = false;
        for (int ring = 1; ring <= kRings && !motion.known; ++ring) motion.known = fit(column, row, ring, motion);
      }
    }
  }
  return prediction_;
}

void MotionPredictor::collect(const Features& reference, const Features& current, const std::vector<Match>& matches,
                              const MotionStatistics& statistics) {
  moments_.assign(prediction_.cells.size(), Moments());
  const auto far = [this](float apart, float reach) {
    constexpr float kPixel = 1;  // the noise of keypoints, where all others agree better than that
    const auto sigma = static_cast<float>((reach - margin_) / kReachSigmas);
    return std::abs(apart) > kOutlierSigmas * sigma + kPixel;
  };
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!statistics.accepted[i]) continue;
    const auto cell = static_cast<size_t>(statistics.cell[i]);
    const cv::Point2f& from = reference.keypoints[static_cast<size_t>(matches[i].reference)].pt;
    const cv::Point2f& to = current.keypoints[static_cast<size_t>(matches[i].current)].pt;
    const CellMotion& motion = prediction_.cells[cell];
    if (motion.known) {
      const cv::Point2f apart = to - motion.predict(from);
      if (far(apart.x, motion.reach.x) || far(apart.y, motion.reach.y)) continue;
    }
    const cv::Point2f displacement = to - from;
    const double x = from.x, y = from.y, dx = displacement.x, dy = displacement.y;
    moments_[cell] += Moments(1, x, y, x * x, x * y, y * y, dx, x * dx, y * dx, dx * dx, dy, x * dy, y * dy, dy * dy);
  }
}

bool MotionPredictor::fit(int column, int row, int rings, CellMotion& motion) const {
  Moments sum;
  int all = 0;
  for (int v = std::max(row - rings, 0); v <= std::min(row + rings, prediction_.rows - 1); ++v) {
    for (int u = std::max(column - rings, 0); u <= std::min(column + rings, prediction_.columns - 1); ++u) {
      const size_t cell = static_cast<size_t>(v) * prediction_.columns + u;
      sum += moments_[cell];
      all += all_[cell];
    }
  }
  const double count = sum[0];
  if (count < kLeastMatches || count < kLeastShare[rings - 1] * all) return false;

  // Least squares, with the weight of one match at a cell's distance that the displacement is everywhere the same.
  const double x = sum[1] / count, y = sum[2] / count;
  const double xx = sum[3] - sum[1] * x + cell_.width * cell_.width;
  const double yy = sum[5] - sum[2] * y + cell_.height * cell_.height;
  const double xy = sum[4] - sum[1] * y;
  const double determinant = xx * yy - xy * xy;
  float displacement[2], per_x[2], per_y[2], reach[2];
  for (int k = 0; k < 2; ++k) {
    const double* axis = sum.val + 6 + 4 * k;
    const double d = axis[0] / count;
    const double xd = axis[1] - sum[1] * d, yd = axis[2] - sum[2] * d, dd = axis[3] - axis[0] * d;
    const double slope_x = (xd * yy - yd * xy) / determinant, slope_y = (yd * xx - xd * xy) / determinant;
    constexpr double kFitted = 3;  // numbers
    const double variance = std::max(dd - slope_x * xd - slope_y * yd, 0.) / std::max(count - kFitted, 1.);
    displacement[k] = static_cast<float>(d);
    per_x[k] = static_cast<float>(slope_x);
    per_y[k] = static_cast<float>(slope_y);
    reach[k] = static_cast<float>(kReachSigmas * rings * std::sqrt(variance)) + margin_;
  }
  motion.center = {static_cast<float>(x), static_cast<float>(y)};
  motion.displacement = {displacement[0], displacement[1]};
  motion.per_x = {per_x[0], per_x[1]};
  motion.per_y = {per_y[0], per_y[1]};
  motion.reach = {reach[0], reach[1]};
  return true;
}

}  // namespace gms_ransac
