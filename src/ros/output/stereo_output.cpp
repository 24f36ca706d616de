#include "output/stereo_output.h"

#include <boost/make_shared.hpp>

#include "gms_ransac/camera.h"
#include "output/output_options.h"

namespace gms_ransac {

StereoFeatures stereoFeaturesMessage(const ProcessedFrame& processed) {
  const PreparedFrame& current = *processed.current;
  StereoFeatures message;
  message.header = current.header;
  const MatchResult& result = *processed.result;
  for (size_t i = 0; i < result.matches.size(); ++i) {
    const uint32_t id = (*processed.track_ids)[i];
    const auto keypoint = static_cast<size_t>(result.matches[i].current);
    const Eigen::Vector2d& right = current.stereo.right_ray[keypoint];
    if (id == 0 || !right.allFinite()) continue;
    const Eigen::Vector2d left = rayOf(current.camera->camera, current.frame.features.keypoints[keypoint].pt);
    StereoFeature feature;
    feature.id = id;
    feature.u0 = left.x();
    feature.v0 = left.y();
    feature.u1 = right.x();
    feature.v1 = right.y();
    message.features.push_back(feature);
  }
  return message;
}

StereoOutput::StereoOutput(ros::NodeHandle& outputs, const ros::SubscriberStatusCallback& changed)
    : publisher_(outputs.advertise<StereoFeatures>("stereo_features", kPublisherQueue, changed, changed)) {}

void StereoOutput::publish(const ProcessedFrame& processed) {
  if (listeners() == 0 || processed.result == nullptr || processed.result->inliers == 0) return;
  if (processed.track_ids == nullptr || processed.current->stereo.right_ray.empty()) return;
  publisher_.publish(boost::make_shared<StereoFeatures>(stereoFeaturesMessage(processed)));
}

}  // namespace gms_ransac
