// Whether the inliers of a model are more than chance and spread enough to mean something.
#pragma once

#include "gms_ransac/robust_estimator.h"
#include "robust/stopping.h"

namespace gms_ransac {

class Acceptance {
 public:
  /// Reads result.inlier and inlier_count; false when the support could be chance for a model of `sample_size` points
  /// or when the inliers of one image lie on a line up to the threshold.
  bool accepts(const PointPairs& pairs, int sample_size, double threshold_px, const RobustResult& result);

 private:
  ChanceSupport chance_;
};

}  // namespace gms_ransac
