// Options of the outputs that can change at run time.
#pragma once

#include "output/feature_stream.h"
#include "output/overlay.h"

namespace gms_ransac {

constexpr uint32_t kPublisherQueue = 10;  ///< messages that wait for a slow listener

struct OutputOptions {
  bool publish_rejected = false;
  bool publish_relative_tf = true;
  bool publish_odom_tf = false;
  FeatureOptions features;
  OverlayOptions overlay;
};

}  // namespace gms_ransac
