// Options of the outputs that can change at run time, and what all outputs do to publish.
#pragma once

#include <type_traits>
#include <utility>

#include <ros/publisher.h>
#include <boost/make_shared.hpp>

#include "output/feature_stream.h"
#include "output/overlay.h"

namespace gms_ransac {

constexpr uint32_t kPublisherQueue = 10;  ///< messages that wait for a slow listener

inline bool hasSubscriber(const ros::Publisher& publisher) { return publisher.getNumSubscribers() > 0; }

/// Publishes without a copy for subscribers in the same process.
template <typename Message>
void publishShared(const ros::Publisher& publisher, Message&& message) {
  publisher.publish(boost::make_shared<std::decay_t<Message>>(std::forward<Message>(message)));
}

struct OutputOptions {
  bool publish_rejected = false;
  bool publish_relative_tf = true;
  bool publish_odom_tf = false;
  FeatureOptions features;
  OverlayOptions overlay;
};

}  // namespace gms_ransac
