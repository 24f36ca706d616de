#include "scale/depth_pose.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace gms_ransac {

namespace {

using Eigen::Vector3d;

constexpr int kMinimumSupport = 8;
// Depth beyond this share of difference between the four pixels around a point lies on a rim, relative.
constexpr double kRim = 0.05;

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

SensorPrior unlearnt(bool two_cameras, double disparity) {
  SensorPrior prior = two_cameras ? LearntRig().prior(disparity) : LearntOffset().prior(disparity);
  prior.shared_from = static_cast<int>(prior.mean.size());
  return prior;
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

DepthEstimate poseFromKeypointDepth(const DepthPair& pair, RelativePose& pose, KeyFrame* key, LearntSensor* sensor) {
  DepthEstimate estimate;
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
  const double disparity = reader.pixel() / pair.baseline;
  const SensorPrior prior = sensor ? sensor->prior(disparity) : unlearnt(start.two_cameras, disparity);
  const std::optional<JointEstimate> joint = refineJointly(points.joint, start, prior, false);
  if (!joint) return estimate;
  pose = joint->pose;
  estimate.by_sensor = joint->shared;
  std::optional<SensorEvidence> evidence = joint->sensor;
  if (key) {
    const std::optional<SensorEvidence> of_key = key->locate(pair, reader, points, prior, *joint);
    // Points near by tell most of a rig, and leave the view first; the offset of a depth camera takes a long way.
    if (!start.two_cameras) evidence = of_key;
  }
  if (sensor && evidence) sensor->add(*evidence, disparity);
  estimate.length = pose.t.norm();
  const Vector3d along = pose.t.normalized();
  estimate.relative_sigma =
      estimate.length > 0 ? std::sqrt(along.dot(pose.covariance.topLeftCorner<3, 3>() * along)) / estimate.length : 0;
  estimate.features = matches;
  return estimate;
}

}  // namespace gms_ransac
