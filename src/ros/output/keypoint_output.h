// ~keypoints: the features of the current image as they are.
#pragma once

#include <gms_ransac/Keypoints.h>
#include <ros/node_handle.h>

#include "stream/processed_frame.h"

namespace gms_ransac {

/// The image must have been of use (not BAD_IMAGE).
Keypoints keypointsMessage(const ProcessedFrame& processed);

class KeypointOutput {
 public:
  KeypointOutput(ros::NodeHandle& outputs, const ros::SubscriberStatusCallback& listeners_changed);

  int listeners() const { return static_cast<int>(publisher_.getNumSubscribers()); }
  void publish(const ProcessedFrame& processed);

 private:
  ros::Publisher publisher_;
};

}  // namespace gms_ransac
