#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "gms_ransac/translation_scale.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr int kMinimumSupport = 8;
constexpr int kIterations = 15;
// Cauchy loss: wrong depth at the rims of things, which registration and time difference smear, must not pull.
constexpr double kLossPixels = 1.0;
// Depth beyond this share of difference between the four pixels around a point lies on a rim, relative.
constexpr double kRim = 0.05;

/// A point of one image with metric depth and where the other image shows it, normalised coordinates.
struct DepthPoint {
  Vector3d point;             ///< in the frame that has the depth, metres
  double x, y;                ///< seen in the other image
  bool in_current;            ///< `point` is in the current frame, seen in the reference
  double triangulated_depth;  ///< of `point`, in multiples of the baseline; 0: unknown
};

/// Metres at a pixel of the received image, 0 where unknown or at a rim.
double depthAt(const cv::Mat& depth, const cv::Point2f& pixel) {
  if (depth.empty()) return 0;
  const int x = static_cast<int>(pixel.x), y = static_cast<int>(pixel.y);
  if (x < 0 || y < 0 || x + 1 >= depth.cols || y + 1 >= depth.rows) return 0;
  const float z[4] = {depth.at<float>(y, x), depth.at<float>(y, x + 1), depth.at<float>(y + 1, x),
                      depth.at<float>(y + 1, x + 1)};
  const auto [low, high] = std::minmax_element(z, z + 4);
  for (float value : z) {
    if (!(value > 0) || !std::isfinite(value)) return 0;
  }
  if (*high - *low > kRim * *low) return 0;
  const double a = pixel.x - x, b = pixel.y - y;
  // Inverse depth is what is linear on a plane.
  const double top = (1 - a) / z[0] + a / z[1], bottom = (1 - a) / z[2] + a / z[3];
  return 1 / ((1 - b) * top + b * bottom);
}

std::vector<DepthPoint> gatherPoints(const Triangulation& pair, const Features& reference, const Features& current,
                                     const MatchResult& result, const cv::Mat& reference_depth,
                                     const cv::Mat& current_depth) {
  std::vector<DepthPoint> points;
  for (int i = 0; i < pair.size(); ++i) {
    const Match& match = result.matches[pair.match[i]];
    const double zr = depthAt(reference_depth, reference.keypoints[match.reference].pt);
    const double zc = depthAt(current_depth, current.keypoints[match.current].pt);
    const Vector3d ray_r(pair.x_reference[i], pair.y_reference[i], 1), ray_c(pair.x_current[i], pair.y_current[i], 1);
    if (zr > 0) {
      points.push_back({zr * ray_r, ray_c.x(), ray_c.y(), false, pair.valid[i] ? pair.depth_reference[i] : 0});
    }
    if (zc > 0) {
      points.push_back({zc * ray_c, ray_r.x(), ray_r.y(), true, pair.valid[i] ? pair.depth_current[i] : 0});
    }
  }
  return points;
}

/// Weighted median of metric over triangulated depth. Inverse triangulated depth has the same noise everywhere, so
/// the ratio's standard deviation grows with the metric depth.
double startingLength(const std::vector<DepthPoint>& points) {
  std::vector<std::pair<double, double>> ratios;
  double total = 0;
  for (const DepthPoint& p : points) {
    if (p.triangulated_depth <= 0) continue;
    ratios.emplace_back(p.point.z() / p.triangulated_depth, 1 / p.point.z());
    total += 1 / p.point.z();
  }
  if (ratios.empty()) return 0;
  std::sort(ratios.begin(), ratios.end());
  double sum = 0;
  for (const auto& [ratio, weight] : ratios) {
    sum += weight;
    if (sum >= total / 2) return ratio;
  }
  return ratios.back().first;
}

Matrix3d skew(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Normal equations at a pose for the perturbation (dt, w): t + dt, exp(w) R.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double weighted_squares = 0, weight = 0;

  void add(const DepthPoint& p, const RelativePose& pose, double loss) {
    Vector3d seen;                           // the point in the frame of the image that shows it
    Eigen::Matrix<double, 3, 6> derivative;  // of `seen`
    if (p.in_current) {
      const Vector3d turned = pose.R * p.point;
      seen = turned + pose.t;
      derivative << Matrix3d::Identity(), -skew(turned);
    } else {
      const Vector3d shifted = p.point - pose.t;
      const Matrix3d back = pose.R.transpose();
      seen = back * shifted;
      derivative << -back, back * skew(shifted);
    }
    if (seen.z() <= 0) return;
    const double x = seen.x() / seen.z(), y = seen.y() / seen.z();
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1, 0, -x, 0, 1, -y;
    const Eigen::Matrix<double, 2, 6> J = projection / seen.z() * derivative;
    const Eigen::Vector2d residual(x - p.x, y - p.y);
    const double w = 1 / (1 + residual.squaredNorm() / (loss * loss));
    H += w * J.transpose() * J;
    b -= w * J.transpose() * residual;
    weighted_squares += w * residual.squaredNorm();
    weight += w;
  }
};

}  // namespace

ScaleEstimate poseFromDepth(const Triangulation& pair, const Features& reference, const Features& current,
                            const MatchResult& result, const Camera& camera, const cv::Mat& reference_depth,
                            const cv::Mat& current_depth, RelativePose& pose) {
  ScaleEstimate estimate;
  const std::vector<DepthPoint> points = gatherPoints(pair, reference, current, result, reference_depth, current_depth);
  if (static_cast<int>(points.size()) < kMinimumSupport) return estimate;

  RelativePose refined = result.robust.pose;
  refined.t *= startingLength(points);
  const double loss = kLossPixels / camera.meanFocalLength();
  NormalEquations equations;
  for (int i = 0; i < kIterations; ++i) {
    equations = NormalEquations();
    for (const DepthPoint& p : points) equations.add(p, refined, loss);
    const Vector6d step = equations.H.ldlt().solve(equations.b);
    if (!step.allFinite()) return estimate;
    refined.t += step.head<3>();
    const Vector3d w = step.tail<3>();
    if (w.norm() > 0) refined.R = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix() * refined.R;
    if (step.norm() < 1e-9) break;
  }
  const double variance = equations.weighted_squares / (2 * std::max(equations.weight - 3, 1.0));
  refined.covariance = variance * equations.H.ldlt().solve(Matrix6d::Identity());
  if (!refined.covariance.allFinite()) return estimate;
  estimate.length = refined.t.norm();
  const Vector3d along = refined.t.normalized();
  estimate.relative_sigma =
      estimate.length > 0 ? std::sqrt(along.dot(refined.covariance.topLeftCorner<3, 3>() * along)) / estimate.length
                          : 0;
  estimate.support = static_cast<int>(points.size());
  pose = refined;
  return estimate;
}

}  // namespace gms_ransac
