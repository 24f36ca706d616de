// What of the outputs can change at run time.
#pragma once

#include "output/feature_stream.h"

namespace gms_ransac {

struct OutputOptions {
  bool publish_rejected = false;
  bool publish_relative_tf = true;
  bool publish_odom_tf = false;
  FeatureOptions features;
};

}  // namespace gms_ransac
