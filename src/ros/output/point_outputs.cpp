#include "output/point_outputs.h"

#include <algorithm>
#include <cstring>

#include <sensor_msgs/point_cloud2_iterator.h>
#include <Eigen/Geometry>
#include <boost/make_shared.hpp>

#include "frames.h"
#include "gms_ransac/camera.h"
#include "output/output_options.h"
#include "output/overlay.h"

namespace gms_ransac {

namespace {

constexpr double kFrustumDepth = 1;       // of the drawn cameras, in units of the translation
constexpr double kLeastMetricStep = 0.1;  // metres: a smaller camera could not be seen
constexpr double kFlowWidth = 0.002;      // of the drawn lines at depth 1
constexpr double kFrustumWidth = 0.06;    // of its lines, in the same unit

std_msgs::ColorRGBA color(float quality) {
  const cv::Scalar bgr = qualityColor(quality);
  std_msgs::ColorRGBA rgba;
  rgba.r = static_cast<float>(bgr[2] / 255);
  rgba.g = static_cast<float>(bgr[1] / 255);
  rgba.b = static_cast<float>(bgr[0] / 255);
  rgba.a = 1;
  return rgba;
}

visualization_msgs::Marker lines(const std_msgs::Header& header, const char* name, double width) {
  visualization_msgs::Marker marker;
  marker.header = header;
  marker.ns = name;
  marker.type = visualization_msgs::Marker::LINE_LIST;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1;
  marker.scale.x = width;
  return marker;
}

/// The eight edges of a camera's view.
void addFrustum(const Camera& camera, const Eigen::Isometry3d& pose, double depth, visualization_msgs::Marker& marker) {
  const float w = static_cast<float>(camera.imageSize().width), h = static_cast<float>(camera.imageSize().height);
  const cv::Point2f pixels[4] = {{0, 0}, {w, 0}, {w, h}, {0, h}};
  Eigen::Vector3d corners[4];
  for (int i = 0; i < 4; ++i) {
    // Without the distortion: at the corners of a wide lens its inverse need not exist.
    const CameraIntrinsics& k = camera.intrinsics();
    corners[i] = pose * (depth * Eigen::Vector3d((pixels[i].x - k.cx) / k.fx, (pixels[i].y - k.cy) / k.fy, 1));
  }
  for (int i = 0; i < 4; ++i) {
    marker.points.push_back(toMessage(pose.translation()));
    marker.points.push_back(toMessage(corners[i]));
    marker.points.push_back(toMessage(corners[i]));
    marker.points.push_back(toMessage(corners[(i + 1) % 4]));
  }
}

}  // namespace

sensor_msgs::PointCloud2 pointsMessage(const ProcessedFrame& processed, const Triangulation& points) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = processed.current->header;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  using sensor_msgs::PointField;
  modifier.setPointCloud2Fields(5, "x", 1, PointField::FLOAT32, "y", 1, PointField::FLOAT32, "z", 1,
                                PointField::FLOAT32, "intensity", 1, PointField::FLOAT32, "id", 1, PointField::UINT32);
  modifier.resize(static_cast<size_t>(std::count(points.valid.begin(), points.valid.end(), uint8_t{1})));
  sensor_msgs::PointCloud2Iterator<float> xyz(cloud, "x"), intensity(cloud, "intensity");
  sensor_msgs::PointCloud2Iterator<uint32_t> id(cloud, "id");
  const double scale = processed.pose.t.norm();
  for (int i = 0; i < points.size(); ++i) {
    if (!points.valid[i]) continue;
    const Eigen::Vector3f p = (scale * points.point(i)).cast<float>();
    std::copy(p.data(), p.data() + 3, &xyz[0]);
    *intensity = processed.result->probability[points.match[i]];
    *id = (*processed.track_ids)[points.match[i]];
    ++xyz;
    ++intensity;
    ++id;
  }
  return cloud;
}

visualization_msgs::MarkerArray markerMessage(const ProcessedFrame& processed) {
  const MatchResult& result = *processed.result;
  const Camera& camera = processed.current->camera->camera;
  visualization_msgs::MarkerArray message;
  visualization_msgs::Marker flow = lines(processed.current->header, "flow", kFlowWidth);
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (result.stage[i] != MatchStage::kInlier) continue;
    const Eigen::Vector2d from =
        rayOf(camera, processed.reference->frame.features.keypoints[result.matches[i].reference].pt);
    const Eigen::Vector2d to = rayOf(camera, processed.current->frame.features.keypoints[result.matches[i].current].pt);
    flow.points.push_back(toMessage(from.homogeneous()));
    flow.points.push_back(toMessage(to.homogeneous()));
    flow.colors.resize(flow.points.size(), color(result.probability[i]));
  }
  message.markers.push_back(flow);
  if (!processed.poseValid()) return message;

  Eigen::Isometry3d reference = Eigen::Isometry3d::Identity();
  reference.linear() = processed.pose.R.transpose();
  reference.translation() = -(processed.pose.R.transpose() * processed.pose.t);
  const double length = processed.pose.t.norm();
  const double step = processed.metric_scale ? std::max(length, kLeastMetricStep) : length > 0 ? length : 1;
  visualization_msgs::Marker current_view = lines(processed.current->header, "current", kFrustumWidth * step);
  current_view.color = color(1);
  addFrustum(camera, Eigen::Isometry3d::Identity(), kFrustumDepth * step, current_view);
  visualization_msgs::Marker reference_view = lines(processed.current->header, "reference", kFrustumWidth * step);
  reference_view.color = color(0);
  addFrustum(camera, reference, kFrustumDepth * step, reference_view);
  message.markers.push_back(current_view);
  message.markers.push_back(reference_view);
  return message;
}

PointOutputs::PointOutputs(ros::NodeHandle& outputs, const Parameters& parameters,
                           const ros::SubscriberStatusCallback& changed)
    : features_(outputs, parameters, changed) {
  points_ = outputs.advertise<sensor_msgs::PointCloud2>("inlier_points", kPublisherQueue, changed, changed);
  markers_ = outputs.advertise<visualization_msgs::MarkerArray>("match_markers", kPublisherQueue, changed, changed);
}

int PointOutputs::listeners() const {
  return features_.listeners() + static_cast<int>(points_.getNumSubscribers() + markers_.getNumSubscribers());
}

void PointOutputs::publish(const ProcessedFrame& processed, const FeatureOptions& features) {
  features_.publish(processed, features);
  if (processed.result == nullptr || processed.result->inliers == 0 || !processed.current->camera->camera.calibrated())
    return;
  if (points_.getNumSubscribers() > 0 && processed.status == MatchStats::OK) {
    triangulateInliers(processed.reference->frame.features, processed.current->frame.features, *processed.result,
                       processed.current->camera->camera, triangulation_);
    points_.publish(boost::make_shared<sensor_msgs::PointCloud2>(pointsMessage(processed, triangulation_)));
  }
  if (markers_.getNumSubscribers() > 0) {
    markers_.publish(boost::make_shared<visualization_msgs::MarkerArray>(markerMessage(processed)));
  }
}

}  // namespace gms_ransac
