// The room scale gives a translation its length: from depth, a second camera, the ground, or the pair before. Matches
// and their flags stay as they are.
//
// Motion in metres from depth: of a pair, and of the current image since an earlier one, the key frame.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/triangulation.h"
#include "scale/key_frame.h"
#include "scale/learnt_sensor.h"
#include "scale/pair_points.h"
#include "scale/translation_scale.h"

namespace gms_ransac {

/// Depth at every keypoint, metres, 0 where unknown or at a depth edge. `depth`: CV_32FC1 metres, not positive or not
/// finite where unknown; empty: no entries.
std::vector<float> keypointDepth(const Features& features, const cv::Mat& depth);

struct DepthEstimate : ScaleEstimate {
  /// Errors of the pose by the sensor, which all pairs of a stream share: a column each of independent ones, one
  /// standard deviation. Rows as in RelativePose::covariance, which has them instead if nothing is learnt.
  Eigen::Matrix<double, 6, 4> by_sensor = Eigen::Matrix<double, 6, 4>::Zero();
};

/// One pose from all that was measured of a pair, by robust least squares from `result.robust.judgement.pose`: inliers
/// with depth as points in space, with the noise of depth or disparity; the others by their Sampson distance. With
/// pixels the inliers are aligned before. Rotation, translation and covariance are joint. `features` 0 (fewer than
/// eight inliers with depth, or no solution) leaves `pose` alone. `key`: locates the current image in it as well.
/// `sensor`: holds the pair, and learns from it.
DepthEstimate poseFromKeypointDepth(const DepthPair& pair, RelativePose& pose, KeyFrame* key = nullptr,
                                    LearntSensor* sensor = nullptr);

}  // namespace gms_ransac
