// Accepts the inliers of a model if they are more than chance and spread over the image.
#pragma once

#include <vector>

#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_result.h"
#include "ransac/sampler.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

/// Reads result.inlier and inlier_count. Returns false if the support could be chance for a model of `sample_size`
/// points. Returns false, too, if the inliers lie in too few spots of the images to check the model, or, up to the
/// threshold, on a line of one image. `order`: slots by rank, if there is such an order. Then support among the first
/// half, quarter or eighth of them that is no chance suffices, as in PROSAC (Chum & Matas 2005). `chance`: storage.
bool inliersAreAccepted(const PointPairs& pairs, const TwoViewPoints& points, int sample_size, double threshold_px,
                        const RobustResult& result, const std::vector<int>* order, ChanceSupport& chance);

}  // namespace gms_ransac
