#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "scale/translation_scale.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
// Unknowns: the step of t, the rotation vector w, and the row rotation.
constexpr int kUnknowns = 9;
using Matrix9d = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Vector9d = Eigen::Matrix<double, kUnknowns, 1>;

constexpr int kMinimumSupport = 8;
constexpr int kIterations = 15;
constexpr double kConverged = 1e-6;  // step, metres and radians: a thousandth of the noise; each is a third of the last
// Cauchy loss: wrong depth at the rims of things, which registration and time difference smear, must not pull. After
// some steps it bends at a multiple of the root mean square residual if that is less. In the rendered room the corners
// near rims have a mean error of 0.15 px and caused half of the yaw drift.
constexpr double kLossPixels = 1.0, kLeastLossPixels = 0.1, kLossResiduals = 1.4;
constexpr int kWideSteps = 3;
// Depth beyond this share of difference between the four pixels around a point lies on a rim, relative.
constexpr double kRim = 0.05;
// Prior standard deviation of the row rotation, radians: half a degree to one degree on a hand-held Kinect.
constexpr double kRowRotationSigma = 3.14159265358979323846 / 180;
constexpr double kNoRowRotationSigma = 1e-6;  // global shutter

/// A point of one image with metric depth and where the other image shows it, normalised coordinates.
struct DepthPoint {
  Vector3d point;             ///< in the frame that has the depth, metres
  double x, y;                ///< seen in the other image
  double row, seen_row;       ///< in the image with the depth and in the other: -0.5 at the top, 0.5 at the bottom
  bool in_current;            ///< `point` is in the current frame, seen in the reference
  double triangulated_depth;  ///< of `point`, in multiples of the baseline; 0: unknown
};

/// Motion of rolling-shutter cameras. If the rotation during the readout differs between the images, the difference
/// grows with the row; without it in the model it would be taken for translation.
struct RowwiseMotion {
  RelativePose pose;  ///< of the middle rows
  Vector3d row_rotation =
      Vector3d::Zero();  ///< rotation vector, current minus reference, from the top row to the bottom
};

double depthAt(const cv::Mat& depth, const cv::Point2f& pixel) {
  if (!(pixel.x >= 0 && pixel.x < depth.cols - 1 && pixel.y >= 0 && pixel.y < depth.rows - 1)) return 0;
  const int x = static_cast<int>(pixel.x), y = static_cast<int>(pixel.y);
  const float z[4] = {depth.at<float>(y, x), depth.at<float>(y, x + 1), depth.at<float>(y + 1, x),
                      depth.at<float>(y + 1, x + 1)};
  const auto [low, high] = std::minmax_element(z, z + 4);
  for (float value : z) {
    if (!(value > 0) || !std::isfinite(value)) return 0;
  }
  if (*high - *low > kRim * *low) return 0;
  const double a = pixel.x - x, b = pixel.y - y;
  const double top = (1 - a) / z[0] + a / z[1], bottom = (1 - a) / z[2] + a / z[3];
  return 1 / ((1 - b) * top + b * bottom);
}

std::vector<DepthPoint> gatherPoints(const Triangulation& pair, const Features& reference, const Features& current,
                                     const MatchResult& result, const std::vector<float>& reference_depth,
                                     const std::vector<float>& current_depth, int& matches) {
  std::vector<DepthPoint> points;
  matches = 0;
  for (int i = 0; i < pair.size(); ++i) {
    const Match& match = result.matches[pair.match[i]];
    const cv::Point2f pixel_r = reference.keypoints[match.reference].pt, pixel_c = current.keypoints[match.current].pt;
    const double zr = reference_depth.empty() ? 0 : reference_depth[match.reference];
    const double zc = current_depth.empty() ? 0 : current_depth[match.current];
    const double row_r = pixel_r.y / reference.image_size.height - 0.5;
    const double row_c = pixel_c.y / current.image_size.height - 0.5;
    const Vector3d ray_r(pair.x_reference[i], pair.y_reference[i], 1), ray_c(pair.x_current[i], pair.y_current[i], 1);
    const double triangulated_r = pair.valid[i] ? pair.depth_reference[i] : 0;
    const double triangulated_c = pair.valid[i] ? pair.depth_current[i] : 0;
    if (zr > 0) points.push_back({zr * ray_r, ray_c.x(), ray_c.y(), row_r, row_c, false, triangulated_r});
    if (zc > 0) points.push_back({zc * ray_c, ray_r.x(), ray_r.y(), row_c, row_r, true, triangulated_c});
    matches += zr > 0 || zc > 0;
  }
  return points;
}

/// Weighted median of metric over triangulated depth, whose ratio has a standard deviation that grows with depth.
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

/// Normal equations at a motion for the perturbation (dt, w, du): t + dt, exp(w) R, row_rotation + du.
struct DepthEquations {
  Matrix9d H = Matrix9d::Zero();
  Vector9d b = Vector9d::Zero();
  double weighted_squares = 0, weight = 0;

  /// `loss`: where the robust loss bends, also the noise that its prior is weighed against.
  DepthEquations(const std::vector<DepthPoint>& points, const RowwiseMotion& motion, double loss,
                 double row_rotation_sigma) {
    const double prior = loss * loss / (row_rotation_sigma * row_rotation_sigma);
    H.bottomRightCorner<3, 3>().diagonal().setConstant(prior);
    b.tail<3>() = -prior * motion.row_rotation;
    for (const DepthPoint& p : points) add(p, motion, loss);
  }

 private:
  void add(const DepthPoint& p, const RowwiseMotion& motion, double loss) {
    const RelativePose& pose = motion.pose;
    // Half the row rotation belongs to either image, with opposite signs, to first order.
    const Vector3d half_rotation = (p.in_current ? 0.5 : -0.5) * motion.row_rotation;
    const Vector3d point = p.point + p.row * half_rotation.cross(p.point);
    const Matrix3d rotation = p.in_current ? pose.R : Matrix3d(pose.R.transpose());
    const Vector3d rotated = rotation * point;
    const Vector3d moved = p.in_current ? Vector3d(rotated + pose.t) : Vector3d(rotation * (point - pose.t));
    const Vector3d seen = moved + p.seen_row * half_rotation.cross(moved);  // in the frame of the image that shows it
    if (seen.z() <= 0) return;
    Eigen::Matrix<double, 3, kUnknowns> derivative;  // of `seen`
    const Matrix3d by_row_rotation = p.row * rotation * crossMatrix(p.point) + p.seen_row * crossMatrix(moved);
    if (p.in_current) {
      derivative << Matrix3d::Identity(), -crossMatrix(rotated), -0.5 * by_row_rotation;
    } else {
      derivative << -rotation, rotation * crossMatrix(point - pose.t), 0.5 * by_row_rotation;
    }
    const double x = seen.x() / seen.z(), y = seen.y() / seen.z();
    Eigen::Matrix<double, 2, 3> projection;
    projection << 1, 0, -x, 0, 1, -y;
    const Eigen::Matrix<double, 2, kUnknowns> J = projection / seen.z() * derivative;
    const Eigen::Vector2d residual(x - p.x, y - p.y);
    const double w = 1 / (1 + residual.squaredNorm() / (loss * loss));
    // Coefficient by coefficient: products of this size otherwise go through Eigen's blocked kernel, which is slower.
    const Eigen::Matrix<double, kUnknowns, 2> weighted = w * J.transpose();
    H += weighted.lazyProduct(J);
    b -= weighted.lazyProduct(residual);
    weighted_squares += w * residual.squaredNorm();
    weight += w;
  }
};

}  // namespace

std::vector<float> keypointDepth(const Features& features, const cv::Mat& depth) {
  std::vector<float> column;
  if (depth.empty()) return column;
  column.reserve(features.keypoints.size());
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    column.push_back(static_cast<float>(depthAt(depth, keypoint.pt)));
  }
  return column;
}

ScaleEstimate poseFromKeypointDepth(const Triangulation& pair, const Features& reference, const Features& current,
                                    const MatchResult& result, const Camera& camera,
                                    const std::vector<float>& reference_depth, const std::vector<float>& current_depth,
                                    DepthSource source, RelativePose& pose) {
  ScaleEstimate estimate;
  int matches = 0;
  const std::vector<DepthPoint> points =
      gatherPoints(pair, reference, current, result, reference_depth, current_depth, matches);
  if (matches < kMinimumSupport) return estimate;

  RowwiseMotion motion;
  RelativePose& refined = motion.pose;
  refined = result.robust.pose;
  refined.t *= startingLength(points);
  const double pixel = 1 / camera.meanFocalLength();
  double loss = kLossPixels * pixel;
  const double row_rotation_sigma = source == DepthSource::kRollingCamera ? kRowRotationSigma : kNoRowRotationSigma;
  for (int i = 0; i < kIterations; ++i) {
    const DepthEquations equations(points, motion, loss, row_rotation_sigma);
    if (i == kWideSteps) {
      const double residual = std::sqrt(equations.weighted_squares / (2 * equations.weight));
      loss = std::clamp(kLossResiduals * residual, kLeastLossPixels * pixel, loss);
    }
    const Vector9d step = equations.H.ldlt().solve(equations.b);
    if (!step.allFinite()) return estimate;
    refined.t += step.head<3>();
    refined.R = rotationFromVector(step.segment<3>(3)) * refined.R;
    motion.row_rotation += step.tail<3>();
    if (i > kWideSteps && step.norm() < kConverged) break;
  }
  const DepthEquations equations(points, motion, loss, row_rotation_sigma);
  // A match that is projected both ways makes two residuals of one pair of keypoints, which err together.
  const double projections = static_cast<double>(points.size()) / matches;
  const double freedom = std::max(2 * equations.weight / projections - kUnknowns, 1.0);
  const double variance = equations.weighted_squares / freedom;
  const Matrix9d inverse = equations.H.ldlt().solve(Matrix9d::Identity());
  refined.covariance = variance * inverse.topLeftCorner<6, 6>();
  if (!refined.covariance.allFinite()) return estimate;
  estimate.length = refined.t.norm();
  const Vector3d along = refined.t.normalized();
  estimate.relative_sigma =
      estimate.length > 0 ? std::sqrt(along.dot(refined.covariance.topLeftCorner<3, 3>() * along)) / estimate.length
                          : 0;
  estimate.features = matches;
  pose = refined;
  return estimate;
}

}  // namespace gms_ransac
