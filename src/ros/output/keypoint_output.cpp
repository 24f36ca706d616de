#include "output/keypoint_output.h"

#include <algorithm>

#include <boost/make_shared.hpp>

#include "output/message_conversion.h"
#include "output/output_options.h"
#include "scale/translation_scale.h"
#include "two_view/sigma_by_octave.h"

namespace gms_ransac {

namespace {

/// Ids of the keypoints that are tracked from the reference, 0 of the others.
std::vector<uint32_t> trackIds(const ProcessedFrame& processed) {
  std::vector<uint32_t> ids(static_cast<size_t>(processed.current->frame.features.size()), 0);
  if (processed.track_ids == nullptr || processed.result == nullptr) return ids;
  const std::vector<Match>& matches = processed.result->matches;
  for (size_t i = 0; i < std::min(matches.size(), processed.track_ids->size()); ++i) {
    if ((*processed.track_ids)[i] != 0) ids[static_cast<size_t>(matches[i].current)] = (*processed.track_ids)[i];
  }
  return ids;
}

}  // namespace

Keypoints keypointsMessage(const ProcessedFrame& processed) {
  const PreparedFrame& current = *processed.current;
  const Features& features = current.frame.features;
  Keypoints message;
  message.header = current.header;
  message.width = static_cast<uint32_t>(features.image_size.width);
  message.height = static_cast<uint32_t>(features.image_size.height);
  setCamera(*current.camera, message);
  message.scale_factor = features.scale_factor;
  const auto n = static_cast<size_t>(features.size());
  for (auto* column : {&message.u, &message.v, &message.size, &message.angle, &message.response, &message.sigma}) {
    column->reserve(n);
  }
  const bool has_model = processed.result != nullptr && processed.result->robust.model_found;
  const RobustResult no_model;
  const SigmaByOctave sigma(has_model ? processed.result->robust : no_model, features.scale_factor);
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    message.u.push_back(keypoint.pt.x);
    message.v.push_back(keypoint.pt.y);
    message.octave.push_back(static_cast<uint8_t>(keypoint.octave));
    message.size.push_back(keypoint.size);
    message.angle.push_back(keypoint.angle);
    message.response.push_back(keypoint.response);
    message.sigma.push_back(sigma[keypoint.octave]);
  }
  message.track_id = trackIds(processed);
  message.depth = current.depth.empty() ? current.stereo.depth : keypointDepth(features, current.depth);
  if (n > 0)
    message.descriptors.assign(features.descriptors.row(0), features.descriptors.row(0) + n * kDescriptorBytes);
  return message;
}

KeypointOutput::KeypointOutput(ros::NodeHandle& outputs, const ros::SubscriberStatusCallback& changed)
    : publisher_(outputs.advertise<Keypoints>("keypoints", kPublisherQueue, changed, changed)) {}

void KeypointOutput::publish(const ProcessedFrame& processed) {
  if (listeners() == 0 || processed.status == MatchStats::BAD_IMAGE) return;
  publisher_.publish(boost::make_shared<Keypoints>(keypointsMessage(processed)));
}

}  // namespace gms_ransac
