#include "output/feature_output.h"

#include <cmath>
#include <string>
#include <utility>

#include <boost/make_shared.hpp>

#include "output/output_options.h"

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

Quantiles<double> agesOf(const std::vector<Feature>& features) {
  std::vector<double> ages;
  ages.reserve(features.size());
  for (const Feature& feature : features) ages.push_back(feature.age);
  return quantilesOf(std::move(ages));
}

}  // namespace

sensor_msgs::PointCloud featureMessage(const PreparedFrame& current, const std::vector<Feature>& features,
                                       FeatureLayout layout) {
  sensor_msgs::PointCloud cloud;
  cloud.header = current.header;
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

FeatureOutput::FeatureOutput(ros::NodeHandle& outputs, const Parameters& parameters,
                             const ros::SubscriberStatusCallback& listeners_changed)
    : layout_(parameters.feature_layout),
      publisher_(outputs.advertise<sensor_msgs::PointCloud>("features", kPublisherQueue, listeners_changed,
                                                            listeners_changed)),
      stream_(parameters.input) {}

void FeatureOutput::publish(const ProcessedFrame& processed, const FeatureOptions& options) {
  if (listeners() == 0) {
    stream_.reset();
    ages_ = {};
    return;
  }
  const auto features = stream_.next(processed, options);
  if (!features) return;
  ages_ = agesOf(*features);
  publisher_.publish(
      boost::make_shared<sensor_msgs::PointCloud>(featureMessage(*processed.current, *features, layout_)));
}

}  // namespace gms_ransac
