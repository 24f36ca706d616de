// What of the outputs can change at run time.
#pragma once

#include "gms_ransac/track_selector.h"

namespace gms_ransac {

struct OutputOptions {
  bool publish_rejected = false;
  bool publish_relative_tf = true;
  bool publish_odom_tf = false;
  TrackSelectorOptions features;
};

}  // namespace gms_ransac
