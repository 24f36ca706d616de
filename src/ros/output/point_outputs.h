// Outputs computed from the points of a pair: features for VINS, triangulated inliers, markers for rviz.
#pragma once

#include <functional>

#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include "gms_ransac/triangulation.h"
#include "output/feature_output.h"
#include "stream/processed_frame.h"

namespace gms_ransac {

/// Valid points in the current optical frame: x, y, z in units of the published translation, intensity (probability),
/// track id.
sensor_msgs::PointCloud2 pointsMessage(const ProcessedFrame& processed, const Triangulation& points);

/// Flow of the inliers at unit depth, coloured by probability, and the frustums of both cameras; in the current frame.
visualization_msgs::MarkerArray markerMessage(const ProcessedFrame& processed);

class PointOutputs {
 public:
  PointOutputs(ros::NodeHandle& outputs, const Parameters& parameters,
               const ros::SubscriberStatusCallback& listeners_changed);

  int listeners() const;
  FeatureOutput& features() { return features_; }
  const FeatureOutput& features() const { return features_; }
  void publish(const ProcessedFrame& processed, const FeatureOptions& features);

 private:
  FeatureOutput features_;
  ros::Publisher points_, markers_;
  Triangulation triangulation_;
};

}  // namespace gms_ransac
