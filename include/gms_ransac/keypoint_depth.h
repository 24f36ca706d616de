// Depth of keypoints, from a registered depth image or a second camera, and the metric motion that it tells.
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/features.h"
#include "gms_ransac/translation_scale.h"

namespace gms_ransac {

/// Metres along the optical axis at every keypoint, 0 where unknown or at the rim of something. `depth` is CV_32FC1
/// metres of the image's size, not positive or not finite where unknown; empty: no entries.
std::vector<float> keypointDepth(const Features& features, const cv::Mat& depth);

/// What tells the depth of keypoints.
enum class DepthSource {
  kRollingCamera,  ///< depth cameras: their colour image is read row by row
  kTriggeredPair   ///< two cameras: all rows at once
};

/// poseFromDepth with the depths of the keypoints, metres, 0 where unknown; either column may be empty.
ScaleEstimate poseFromKeypointDepth(const Triangulation& pair, const Features& reference, const Features& current,
                                    const MatchResult& result, const Camera& camera,
                                    const std::vector<float>& reference_depth, const std::vector<float>& current_depth,
                                    DepthSource source, RelativePose& pose);

}  // namespace gms_ransac
