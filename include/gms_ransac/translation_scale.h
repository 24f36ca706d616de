// The length of the translation, which two images alone do not tell: carried on from pair to pair, or from depth.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_filter.h"
#include "gms_ransac/triangulation.h"

namespace gms_ransac {

enum class ScaleMode { kUnit, kPropagate, kDepth, kFixed, kOdometry, kGround };

/// Whether lengths are in metres once they are known, which is not so for every pair.
inline bool measuresMetres(ScaleMode mode) {
  return mode == ScaleMode::kDepth || mode == ScaleMode::kOdometry || mode == ScaleMode::kGround;
}

struct ScaleEstimate {
  double length = 1;          ///< of the translation; metres when it came from depth
  double relative_sigma = 0;  ///< standard deviation of `length` over `length`
  int features = 0;           ///< that it rests on; 0: not measured, `length` is the previous one
};

/// `propagate`: features seen in three images have one depth in the middle one, so the translation of the second pair
/// is measured in units of the first's, which has length 1. Inverse depths of features that are seen longer are
/// averaged on, which slows the drift.
class ScalePropagator {
 public:
  /// Length of the translation of this pair, whose inliers these are (`pose.t` of unit length). `after_loss`: it may be
  /// many times longer than others.
  ScaleEstimate update(const Triangulation& pair, const MatchResult& result, const Camera& camera,
                       bool after_loss = false);
  /// Instead of `update` where the camera turned on the spot (`pose.t` is not looked at): depths are carried over, and
  /// the length stays for the next pair that has one.
  void carryThroughTurn(const Triangulation& pair, const MatchResult& result);
  /// The current image of the last `update` or `carryThroughTurn` becomes the reference of the next.
  void advance();
  /// The next pair has length 1 again.
  void reset();

 private:
  /// Of one keypoint, along the optical axis of its image.
  struct InverseDepth {
    double value = 0, variance = 0;  ///< variance 0: unknown
  };
  ScaleEstimate measure(const Triangulation& pair, const MatchResult& result, double pixel, bool after_loss);
  /// Median ratio of those that are seen best; not positive where these lie beyond infinity.
  double startingLength() const;
  void carryOn(const Triangulation& pair, const MatchResult& result, double pixel, double length);

  struct Ratio {
    double unit, unit_variance;    ///< inverse depth by this pair, baseline 1
    double known, known_variance;  ///< inverse depth from before
  };
  std::vector<Ratio> ratios_;
  std::vector<InverseDepth> reference_, current_;
  double length_ = 1;
};

/// `depth`: the motion in metres that explains the inliers best where registered depth says how far they are, by
/// Gauss-Newton on the reprojection error with a robust loss, started from `result.robust.pose` and the weighted
/// median of depth over triangulated depth. Depth cameras read their colour image row by row; a turn that grows with
/// the row is estimated with the motion, which is that of the middle row. `reference_depth` and `current_depth` are
/// CV_32FC1 metres of the images' size, not positive or not finite where unknown; either may be empty.
/// Writes the pose with |t| in metres and its covariance to `pose`; `features` 0 (fewer than eight inliers with depth,
/// or no convergence) leaves it alone.
ScaleEstimate poseFromDepth(const Triangulation& pair, const Features& reference, const Features& current,
                            const MatchResult& result, const Camera& camera, const cv::Mat& reference_depth,
                            const cv::Mat& current_depth, RelativePose& pose);

/// The pose with a translation of that length; the covariance of t is scaled and given its extent along t.
RelativePose withLength(const RelativePose& unit_pose, const ScaleEstimate& scale);

}  // namespace gms_ransac
