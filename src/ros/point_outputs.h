// What is made of the points of a pair: tracked features for VINS, triangulated inliers, and markers for rviz.
#pragma once

#include <functional>

#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include "frame_processor.h"
#include "gms_ransac/triangulation.h"

namespace gms_ransac {

/// The tracked inliers as VINS-Mono (5 channels: id, u, v, and the velocity of x, y) or VINS-Fusion (9 channels: id,
/// camera id, u, v, velocity, and three that it reads but does not need) takes them. Points are the current, ideal
/// (x, y, 1); u, v are its received pixels. The camera must be calibrated.
sensor_msgs::PointCloud featureMessage(const Answer& answer, FeatureLayout layout);

/// Valid points in the current optical frame: x, y, z in units of the published translation, intensity (confidence),
/// track id.
sensor_msgs::PointCloud2 pointsMessage(const Answer& answer, const Triangulation& points);

/// Flow of the inliers at unit depth, coloured by confidence, and the frustums of both cameras; in the current frame.
visualization_msgs::MarkerArray markerMessage(const Answer& answer);

class PointOutputs {
 public:
  PointOutputs(ros::NodeHandle& outputs, const Parameters& parameters,
               const ros::SubscriberStatusCallback& listeners_changed);

  int listeners() const;
  void publish(const Answer& answer);

 private:
  const FeatureLayout layout_;
  ros::Publisher features_, points_, markers_;
  Triangulation triangulation_;
};

}  // namespace gms_ransac
