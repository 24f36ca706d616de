#include "scale/depth_pose.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gms_ransac {

namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr int kMinimumSupport = 8;
// Depth beyond this share of difference between the four pixels around a point lies on a rim, relative.
constexpr double kRim = 0.05;
// Prior standard deviation of the row rotation, radians: half a degree to one degree on a hand-held Kinect.
constexpr double kRowRotationSigma = 3.14159265358979323846 / 180;
// Prior standard deviation of the disparity that the calibration of two cameras leaves, pixels, and of its growth over
// x = 1 and y = 1, and over x^2 = 1. KITTI's rectified images have 0.1 (04, 06) and 0.9 (01), and 1.5 to 2.3 over x^2:
// ignored, they make the translation 0.8, 0.5 and 8 % too long. Pairs measure the offset to 0.1. A road alone does not
// tell the growth with y from the length.
constexpr double kDisparityErrorSigma = 1, kDisparityGrowthSigma = 0.3, kDisparityBendSigma = 1;

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

/// Weighted median of metric over triangulated depth, whose ratio has a standard deviation that grows with depth.
double startingLength(std::vector<std::pair<double, double>> ratios) {
  double total = 0, sum = 0;
  for (const auto& [ratio, weight] : ratios) total += weight;
  std::sort(ratios.begin(), ratios.end());
  for (const auto& [ratio, weight] : ratios) {
    sum += weight;
    if (sum >= total / 2) return ratio;
  }
  return 0;
}

/// Prior standard deviation of each entry of JointMotion::sensor.
Vector4d sensorSigma(double pixel, double baseline) {
  if (baseline <= 0) return Vector4d::Constant(kRowRotationSigma);
  return pixel / baseline *
         Vector4d(kDisparityErrorSigma, kDisparityGrowthSigma, kDisparityGrowthSigma, kDisparityBendSigma);
}

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

ScaleEstimate poseFromKeypointDepth(const DepthPair& pair, RelativePose& pose, KeyFrame* key) {
  ScaleEstimate estimate;
  const PairReader reader(pair);
  const Triangulation& triangulated = pair.points;
  std::vector<std::pair<double, double>> ratios;
  int matches = 0;
  for (int point = 0; point < triangulated.size(); ++point) {
    const double zr = reader.referenceDepth(point), zc = reader.currentDepth(point);
    matches += zr > 0 || zc > 0;
    if (!triangulated.valid[point]) continue;
    if (zr > 0) ratios.emplace_back(zr / triangulated.depth_reference[point], 1 / zr);
    if (zc > 0) ratios.emplace_back(zc / triangulated.depth_current[point], 1 / zc);
  }
  if (matches < kMinimumSupport) return estimate;

  JointMotion start = {pair.result.robust.judgement.pose, pair.baseline > 0};
  const double length = startingLength(std::move(ratios));
  start.pose.t *= length;
  PairPoints points = reader.points();
  for (size_t i = 0; i < points.joint.size(); ++i) {
    const int point = points.sightings[i].point;
    points.joint[i].begin(start.pose, triangulated.valid[point] ? length * triangulated.depth_reference[point] : 0);
  }
  const Vector4d sensor_sigma = sensorSigma(reader.pixel(), pair.baseline);
  if (!refineJointly(points.joint, start, sensor_sigma, false, pose)) return estimate;
  if (key) key->locate(pair, reader, points, sensor_sigma, pose);
  estimate.length = pose.t.norm();
  const Vector3d along = pose.t.normalized();
  estimate.relative_sigma =
      estimate.length > 0 ? std::sqrt(along.dot(pose.covariance.topLeftCorner<3, 3>() * along)) / estimate.length : 0;
  estimate.features = matches;
  return estimate;
}

}  // namespace gms_ransac
