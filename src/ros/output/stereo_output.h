// ~stereo_features: what both cameras see of the tracked points, as msckf_vio takes it.
#pragma once

#include <gms_ransac/StereoFeatures.h>
#include <ros/node_handle.h>

#include "stream/processed_frame.h"

namespace gms_ransac {

/// The tracked inliers that the right camera shows, too. `processed` must have been compared, with calibrated cameras.
StereoFeatures stereoFeaturesMessage(const ProcessedFrame& processed);

class StereoOutput {
 public:
  StereoOutput(ros::NodeHandle& outputs, const ros::SubscriberStatusCallback& listeners_changed);

  int listeners() const { return static_cast<int>(publisher_.getNumSubscribers()); }
  void publish(const ProcessedFrame& processed);

 private:
  ros::Publisher publisher_;
};

}  // namespace gms_ransac
