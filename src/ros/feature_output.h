// ~features: the tracked inliers as VINS-Mono and VINS-Fusion take them.
#pragma once

#include <unordered_map>
#include <vector>

#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud.h>
#include <Eigen/Core>

#include "frame_processor.h"
#include "gms_ransac/track_selector.h"

namespace gms_ransac {

/// Layouts: VINS-Mono has 5 channels (id, u, v, and the velocity of x, y), VINS-Fusion 9 (id, camera id, u, v,
/// velocity, and three that it reads but does not need). Points are the current, ideal (x, y, 1); u, v are its received
/// pixels.
class FeatureOutput {
 public:
  FeatureOutput(ros::NodeHandle& outputs, FeatureLayout layout, const ros::SubscriberStatusCallback& listeners_changed);

  int listeners() const { return static_cast<int>(publisher_.getNumSubscribers()); }
  /// The frame must have inliers and a calibrated camera.
  void publish(const ProcessedFrame& processed, const TrackSelectorOptions& options);
  /// The stamps no longer go on from those before.
  void forgetStamps() { last_rays_.clear(); }

 private:
  struct Feature {
    uint32_t id;
    cv::Point2f pixel;
    Eigen::Vector2d ray;       ///< x, y at depth 1
    Eigen::Vector2d velocity;  ///< of the ray, 1/s
  };
  std::vector<Feature> selectFeatures(const ProcessedFrame& processed, const TrackSelectorOptions& options);
  Eigen::Vector2d velocity(const ProcessedFrame& processed, int match, uint32_t id, const Eigen::Vector2d& ray) const;

  const FeatureLayout layout_;
  ros::Publisher publisher_;
  TrackSelector selector_;
  std::unordered_map<uint32_t, Eigen::Vector2d> last_rays_;  ///< of the last message
  double last_stamp_ = 0;
};

}  // namespace gms_ransac
