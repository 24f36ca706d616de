#include "feature_output.h"

#include <string>

#include <boost/make_shared.hpp>

namespace gms_ransac {

namespace {

constexpr uint32_t kPublisherQueue = 10;
// The layouts carry ids as float32, which is exact up to here.
constexpr uint32_t kFloatIds = 1u << 24;

std::vector<std::string> channelNames(FeatureLayout layout) {
  if (layout == FeatureLayout::kVinsMono) return {"id", "u", "v", "velocity_x", "velocity_y"};
  return {"id", "camera_id", "u", "v", "velocity_x", "velocity_y", "gx", "gy", "gz"};
}

}  // namespace

FeatureOutput::FeatureOutput(ros::NodeHandle& outputs, FeatureLayout layout,
                             const ros::SubscriberStatusCallback& listeners_changed)
    : layout_(layout),
      publisher_(outputs.advertise<sensor_msgs::PointCloud>("features", kPublisherQueue, listeners_changed,
                                                            listeners_changed)) {}

void FeatureOutput::publish(const ProcessedFrame& processed, const TrackSelectorOptions& options) {
  auto cloud = boost::make_shared<sensor_msgs::PointCloud>();
  cloud->header = processed.current->header;
  const std::vector<std::string> names = channelNames(layout_);
  cloud->channels.resize(names.size());
  for (size_t c = 0; c < names.size(); ++c) cloud->channels[c].name = names[c];
  for (const Feature& feature : selectFeatures(processed, options)) {
    geometry_msgs::Point32 p;
    p.x = static_cast<float>(feature.ray.x());
    p.y = static_cast<float>(feature.ray.y());
    p.z = 1;
    cloud->points.push_back(p);
    std::vector<float> values = {static_cast<float>(feature.id % kFloatIds), feature.pixel.x, feature.pixel.y,
                                 static_cast<float>(feature.velocity.x()), static_cast<float>(feature.velocity.y())};
    if (layout_ == FeatureLayout::kVinsFusion) {
      values.insert(values.begin() + 1, 0.f);
      values.resize(names.size(), 0.f);
    }
    for (size_t c = 0; c < values.size(); ++c) cloud->channels[c].values.push_back(values[c]);
  }
  publisher_.publish(cloud);
}

std::vector<FeatureOutput::Feature> FeatureOutput::selectFeatures(const ProcessedFrame& processed,
                                                                  const TrackSelectorOptions& options) {
  const MatchResult& result = *processed.result;
  std::vector<TrackedPoint> points;
  std::vector<int> match;
  for (size_t i = 0; i < result.matches.size(); ++i) {
    const uint32_t id = (*processed.track_ids)[i];
    if (id == 0) continue;
    const cv::Point2f& pixel = processed.current->frame.features.keypoints[result.matches[i].current].pt;
    points.push_back({id, (*processed.track_lengths)[i], pixel});
    match.push_back(static_cast<int>(i));
  }
  std::vector<Feature> features;
  std::unordered_map<uint32_t, Eigen::Vector2d> rays;
  for (const int i : selector_.select(points, processed.current->frame.features.image_size, options)) {
    const TrackedPoint& point = points[i];
    const Eigen::Vector2d ray = rayOf(processed.current->camera->camera, point.current);
    features.push_back({point.id, point.current, ray, velocity(processed, match[i], point.id, ray)});
    rays.emplace(point.id, ray);
  }
  last_rays_.swap(rays);
  last_stamp_ = processed.current->stamp();
  return features;
}

Eigen::Vector2d FeatureOutput::velocity(const ProcessedFrame& processed, int match, uint32_t id,
                                        const Eigen::Vector2d& ray) const {
  const auto last = last_rays_.find(id);
  const double reference_stamp = processed.reference->stamp();
  Eigen::Vector2d before;
  double seconds;
  if (last != last_rays_.end()) {
    before = last->second;
    seconds = processed.current->stamp() - last_stamp_;
  } else if (last_rays_.empty() || reference_stamp >= last_stamp_) {
    const int keypoint = processed.result->matches[match].reference;
    before = rayOf(processed.current->camera->camera, processed.reference->frame.features.keypoints[keypoint].pt);
    seconds = processed.current->stamp() - reference_stamp;
  } else {
    // Over a reference that is held longer it would be an average; VINS's own tracker says 0 of new features, too.
    return Eigen::Vector2d::Zero();
  }
  return seconds > 0 ? Eigen::Vector2d((ray - before) / seconds) : Eigen::Vector2d::Zero();
}

}  // namespace gms_ransac
