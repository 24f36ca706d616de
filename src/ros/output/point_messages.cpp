#include "output/point_messages.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <sensor_msgs/point_cloud2_iterator.h>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "frames.h"
#include "gms_ransac/camera.h"
#include "output/overlay.h"

namespace gms_ransac {

namespace {

// The layouts carry ids as float32, which is exact up to here.
constexpr uint32_t kFloatIds = 1u << 24;

std::vector<std::string> channelNames(FeatureLayout layout) {
  switch (layout) {
    case FeatureLayout::kVinsFusion:
      return {"id", "camera_id", "u", "v", "velocity_x", "velocity_y", "gx", "gy", "gz"};
    case FeatureLayout::kLviSam:
      return {"id", "u", "v", "velocity_x", "velocity_y", "depth"};
    default:
      return {"id", "u", "v", "velocity_x", "velocity_y"};
  }
}

/// Metres; -1: not known, as LVI-SAM has it.
float depthAt(const cv::Mat& depth, const cv::Point2f& pixel) {
  const cv::Point at(cvRound(pixel.x), cvRound(pixel.y));
  if (depth.empty() || !cv::Rect(cv::Point(), depth.size()).contains(at)) return -1;
  const float metres = depth.at<float>(at);
  return std::isfinite(metres) && metres > 0 ? metres : -1;
}

constexpr double kFrustumOfScene = 0.12;  // of the drawn cameras, as a share of the scene's median depth
constexpr double kLeastMetricStep = 0.4;  // metres: of a drawn camera where that depth is not known
constexpr double kFlowWidth = 0.002;      // of the drawn lines at depth 1
constexpr double kFrustumWidth = 0.06;    // of its lines, in its size
constexpr double kNameHeight = 0.35;      // of its name, in its size
// A drawn point has the mean colour of its patch, brightened so that it is seen before a dark background.
constexpr int kPatchRadius = 2;
constexpr double kDarkest = 45, kBrighter = 1.2;
// Depth over its standard deviation from which on a triangulated point is published.
constexpr double kKnownDepth = 5;

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
    const CameraIntrinsics& k = camera.pinhole();
    corners[i] = pose * (depth * Eigen::Vector3d((pixels[i].x - k.cx) / k.fx, (pixels[i].y - k.cy) / k.fy, 1));
  }
  for (int i = 0; i < 4; ++i) {
    marker.points.push_back(toMessage(pose.translation()));
    marker.points.push_back(toMessage(corners[i]));
    marker.points.push_back(toMessage(corners[i]));
    marker.points.push_back(toMessage(corners[(i + 1) % 4]));
  }
}

visualization_msgs::Marker nameOf(const visualization_msgs::Marker& frustum, const char* name, int id, double height) {
  visualization_msgs::Marker marker = lines(frustum.header, "names", 0);
  marker.type = visualization_msgs::Marker::TEXT_VIEW_FACING;
  marker.id = id;
  marker.text = name;
  marker.color = frustum.color;
  marker.scale.z = height;
  marker.pose.position = frustum.points.front();
  return marker;
}

/// Depth of an inlier along the optical axis, in the unit of the pose: measured, or triangulated where the parallax is
/// large enough; 0: not known.
double knownDepth(const ProcessedFrame& processed, const Triangulation& points, int i) {
  const MatchResult& result = processed.pair->result;
  const std::vector<float>& measured = processed.current->stereo.depth;
  const auto keypoint = static_cast<size_t>(result.matches[static_cast<size_t>(points.row[i])].current);
  if (processed.metric_scale && keypoint < measured.size() && measured[keypoint] > 0) return measured[keypoint];
  const double noise =
      M_SQRT2 * result.robust.judgement.sigma_px / processed.current->image.camera->camera.meanFocalLength();
  return points.valid[i] && points.parallax[i] > kKnownDepth * noise ? points.depth_current[i] * processed.pose.t.norm()
                                                                     : 0;
}

/// BGR around a pixel.
cv::Scalar patchColour(const cv::Mat& image, const cv::Point2f& pixel) {
  const cv::Point corner(cvRound(pixel.x) - kPatchRadius, cvRound(pixel.y) - kPatchRadius);
  const cv::Rect patch =
      cv::Rect(corner, cv::Size(2 * kPatchRadius + 1, 2 * kPatchRadius + 1)) & cv::Rect({}, image.size());
  if (patch.empty()) return cv::Scalar::all(255);
  cv::Scalar colour = cv::mean(image(patch));
  if (image.channels() == 1) colour = cv::Scalar::all(colour[0]);
  return cv::Scalar::all(kDarkest) + colour * kBrighter;
}

/// Median of the known depths; 0: none is.
double sceneDepth(const ProcessedFrame& processed) {
  if (processed.pair == nullptr || !processed.pair->triangulated || processed.status != MatchStats::OK) return 0;
  std::vector<double> depths;
  for (int i = 0; i < processed.pair->points.size(); ++i) {
    const double depth = knownDepth(processed, processed.pair->points, i);
    if (depth > 0) depths.push_back(depth);
  }
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

/// Size of the drawn cameras, in the unit of the pose.
double frustumSize(const ProcessedFrame& processed) {
  const double scene = sceneDepth(processed), length = processed.pose.t.norm();
  if (scene > 0) return kFrustumOfScene * scene;
  return processed.metric_scale ? std::max(length, kLeastMetricStep) : length > 0 ? length : 1;
}

}  // namespace

sensor_msgs::PointCloud featureMessage(const PreparedFrame& current, const std::vector<Feature>& features,
                                       FeatureLayout layout) {
  sensor_msgs::PointCloud cloud;
  cloud.header = current.image.header;
  const std::vector<std::string> names = channelNames(layout);
  cloud.channels.resize(names.size());
  for (size_t c = 0; c < names.size(); ++c) cloud.channels[c].name = names[c];
  for (const Feature& feature : features) {
    geometry_msgs::Point32 p;
    p.x = static_cast<float>(feature.ray.x());
    p.y = static_cast<float>(feature.ray.y());
    p.z = 1;
    cloud.points.push_back(p);
    std::vector<float> values = {static_cast<float>(feature.id % kFloatIds), feature.pixel.x, feature.pixel.y,
                                 static_cast<float>(feature.velocity.x()), static_cast<float>(feature.velocity.y())};
    if (layout == FeatureLayout::kLviSam) values.push_back(depthAt(current.depth, feature.pixel));
    if (layout == FeatureLayout::kVinsFusion) {
      values.insert(values.begin() + 1, 0.f);
      values.resize(names.size(), 0.f);
    }
    for (size_t c = 0; c < values.size(); ++c) cloud.channels[c].values.push_back(values[c]);
  }
  return cloud;
}

sensor_msgs::PointCloud2 pointsMessage(const ProcessedFrame& processed, const Triangulation& points) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = processed.current->image.header;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  using sensor_msgs::PointField;
  modifier.setPointCloud2Fields(6, "x", 1, PointField::FLOAT32, "y", 1, PointField::FLOAT32, "z", 1,
                                PointField::FLOAT32, "intensity", 1, PointField::FLOAT32, "id", 1, PointField::UINT32,
                                "rgb", 1, PointField::FLOAT32);
  const cv::Mat image = receivedColours(*processed.current);
  std::vector<double> depths;
  depths.reserve(static_cast<size_t>(points.size()));
  for (int i = 0; i < points.size(); ++i) depths.push_back(knownDepth(processed, points, i));
  modifier.resize(depths.size() - static_cast<size_t>(std::count(depths.begin(), depths.end(), 0)));
  sensor_msgs::PointCloud2Iterator<float> xyz(cloud, "x"), intensity(cloud, "intensity");
  sensor_msgs::PointCloud2Iterator<uint32_t> id(cloud, "id");
  sensor_msgs::PointCloud2Iterator<uint8_t> blue(cloud, "b");
  for (int i = 0; i < points.size(); ++i) {
    const double depth = depths[static_cast<size_t>(i)];
    if (depth == 0) continue;
    const Eigen::Vector3f p = (depth * Eigen::Vector3d(points.x_current[i], points.y_current[i], 1)).cast<float>();
    std::copy(p.data(), p.data() + 3, &xyz[0]);
    const auto row = static_cast<size_t>(points.row[i]);
    *intensity = processed.pair->result.probability(row);
    *id = processed.pair->track_ids[row];
    const int keypoint = processed.pair->result.matches[row].current;
    const cv::Scalar bgr = patchColour(image, processed.current->frame.features.keypoints[keypoint].pt);
    for (int channel = 0; channel < 3; ++channel) blue[channel] = cv::saturate_cast<uint8_t>(bgr[channel]);
    ++blue;
    ++xyz;
    ++intensity;
    ++id;
  }
  return cloud;
}

visualization_msgs::MarkerArray markerMessage(const ProcessedFrame& processed) {
  visualization_msgs::MarkerArray message;
  // Nothing stays of the image before.
  message.markers.push_back(lines(processed.current->image.header, "", 0));
  message.markers.back().action = visualization_msgs::Marker::DELETEALL;
  if (processed.pair == nullptr || processed.pair->result.inliers == 0) return message;
  const MatchResult& result = processed.pair->result;
  const Camera& camera = processed.current->image.camera->camera;
  visualization_msgs::Marker flow = lines(processed.current->image.header, "flow", kFlowWidth);
  for (size_t row = 0; row < result.matches.size(); ++row) {
    if (!result.isInlier(row)) continue;
    const Match& match = result.matches[row];
    const Eigen::Vector2d from = rayOf(camera, processed.pair->reference->frame.features.keypoints[match.reference].pt);
    const Eigen::Vector2d to = rayOf(camera, result.current_pixel[row]);
    flow.points.push_back(toMessage(from.homogeneous()));
    flow.points.push_back(toMessage(to.homogeneous()));
    flow.colors.resize(flow.points.size(), color(result.probability(row)));
  }
  message.markers.push_back(flow);
  if (!processed.poseValid()) return message;

  const Eigen::Isometry3d reference = toIsometry(processed.pose).inverse();
  const double size = frustumSize(processed);
  visualization_msgs::Marker current_view = lines(processed.current->image.header, "current", kFrustumWidth * size);
  current_view.color = color(1);
  addFrustum(camera, Eigen::Isometry3d::Identity(), size, current_view);
  visualization_msgs::Marker reference_view = lines(processed.current->image.header, "reference", kFrustumWidth * size);
  reference_view.color = color(0);
  addFrustum(camera, reference, size, reference_view);
  message.markers.push_back(current_view);
  message.markers.push_back(reference_view);
  message.markers.push_back(nameOf(current_view, "now", 0, kNameHeight * size));
  // Closer together the names would cover each other.
  if (processed.pose.t.norm() > size)
    message.markers.push_back(nameOf(reference_view, "reference", 1, kNameHeight * size));
  return message;
}

}  // namespace gms_ransac
