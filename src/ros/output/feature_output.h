// ~features: what FeatureStream chose, in the layouts that estimators read.
#pragma once

#include <vector>

#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud.h>

#include "output/feature_stream.h"
#include "quantiles.h"

namespace gms_ransac {

/// Points are the current, ideal (x, y, 1); u, v their received pixels. The channels of a layout, in its order.
/// VINS-Mono: id, u, v and the velocity of x, y. LVI-SAM: these and the depth, metres along the optical axis, -1 if
/// unknown. VINS-Fusion: id, camera id, u, v, velocity and three that it reads but does not need.
sensor_msgs::PointCloud featureMessage(const PreparedFrame& current, const std::vector<Feature>& features,
                                       FeatureLayout layout);

class FeatureOutput {
 public:
  FeatureOutput(ros::NodeHandle& outputs, const Parameters& parameters,
                const ros::SubscriberStatusCallback& listeners_changed);

  int listeners() const { return static_cast<int>(publisher_.getNumSubscribers()); }
  /// As FeatureStream has it.
  bool passesOver(const PreparedFrame& frame, const FeatureOptions& options) {
    return stream_.passesOver(frame, options);
  }
  /// For every image that is not skipped, with or without subscribers.
  void publish(const ProcessedFrame& processed, const FeatureOptions& options);
  /// Ages of the features in the last message, seconds; zero without a subscriber.
  const Quantiles<double>& ages() const { return ages_; }

 private:
  const FeatureLayout layout_;
  ros::Publisher publisher_;
  FeatureStream stream_;
  Quantiles<double> ages_;
};

}  // namespace gms_ransac
