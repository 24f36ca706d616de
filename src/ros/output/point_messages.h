// The points of a pair as messages: features for estimators, triangulated inliers, markers for rviz.
#pragma once

#include <vector>

#include <sensor_msgs/PointCloud.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include "gms_ransac/triangulation.h"
#include "output/feature_stream.h"
#include "stream/processed_frame.h"

namespace gms_ransac {

/// Points are the current, ideal (x, y, 1); u, v their received pixels. The channels of a layout, in its order.
/// VINS-Mono: id, u, v and the velocity of x, y. LVI-SAM: these and the depth, metres along the optical axis, -1 if
/// unknown. VINS-Fusion: id, camera id, u, v, velocity and three that it reads but does not need.
sensor_msgs::PointCloud featureMessage(const PreparedFrame& current, const std::vector<Feature>& features,
                                       FeatureLayout layout);

/// Valid points in the current optical frame: x, y, z in units of the published translation, intensity (probability),
/// track id, rgb (colour of the image at the point; grey of a grey image, white without pixels).
sensor_msgs::PointCloud2 pointsMessage(const ProcessedFrame& processed, const Triangulation& points);

/// Flow of the inliers at unit depth, coloured by probability, and the frustums of both cameras; in the current frame.
visualization_msgs::MarkerArray markerMessage(const ProcessedFrame& processed);

}  // namespace gms_ransac
