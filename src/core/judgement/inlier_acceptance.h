// Accepts the inliers of a model if they are more than chance and spread over the image.
#pragma once

#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_result.h"
#include "ransac/sampler.h"

namespace gms_ransac {

/// Reads result.inlier and inlier_count. Returns false if the support could be chance for a model of `sample_size`
/// points. Returns false, too, if the inliers lie in too few spots of the images to check the model, or, up to the
/// threshold, on a line of one image. `chance`: storage.
bool inliersAreAccepted(const PointPairs& pairs, int sample_size, double threshold_px, const RobustResult& result,
                        ChanceSupport& chance);

}  // namespace gms_ransac
