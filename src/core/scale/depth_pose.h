// Motion in metres from depth: of a pair, and of the current image since an earlier one, the key frame.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_result.h"
#include "gms_ransac/triangulation.h"
#include "scale/translation_scale.h"

namespace gms_ransac {

/// Depth at every keypoint, metres, 0 where unknown or at a depth edge. `depth`: CV_32FC1 metres, not positive or not
/// finite where unknown; empty: no entries.
std::vector<float> keypointDepth(const Features& features, const cv::Mat& depth);

/// A point in one image: x, y on the plane z = 1 and inverse depth, 1/m. In these the motion and its noise are nearly
/// linear, out to infinity.
struct SeenPoint {
  Eigen::Vector3d value, variance;
  bool has_depth;
  double row;  ///< -0.5 at the top of the image, 0.5 at the bottom
};

/// An earlier image whose points are still followed. The motion since it is that of the pairs chained, and what its
/// points tell by themselves; so the noise of the pairs between does not add up.
struct KeyFrame {
  struct Point {
    uint32_t track;
    SeenPoint seen;
  };
  std::vector<Point> points;        ///< in the order of their tracks
  RelativePose reference, current;  ///< of these cameras in that of the key frame, metres
  bool is_reference = true;         ///< it became the key frame with this pair

  /// The current image is the reference of the next pair.
  void advance() { reference = current; }
};

/// A pair with depths at its keypoints.
struct DepthPair {
  const Triangulation& points;  ///< of its inliers
  const Features &reference, &current;
  const MatchResult& result;
  const Camera& camera;
  const std::vector<float>&reference_depth, &current_depth;  ///< metres, 0 where unknown; either may be empty
  /// Metres between two cameras, whose disparities may have a common offset; 0: a depth camera, whose rotation may grow
  /// with the row.
  double baseline;
  const std::vector<uint32_t>& track_ids;  ///< one for each match of the result, 0: not followed; for a key frame alone
};

/// One pose from all that was measured of a pair, by robust least squares from `result.robust.pose`: inliers with depth
/// as points in space, with the noise of depth or disparity; the others by their Sampson distance. Rotation,
/// translation and covariance are joint. `features` 0 (fewer than eight inliers with depth, or no solution) leaves
/// `pose` alone. `key`: locates the current image in it as well.
ScaleEstimate poseFromKeypointDepth(const DepthPair& pair, RelativePose& pose, KeyFrame* key = nullptr);

}  // namespace gms_ransac
