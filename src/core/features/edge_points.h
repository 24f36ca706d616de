// Corners that are none: points of a straight edge, which match anywhere along it.
#pragma once

#include <vector>

#include "features/corner_detector.h"

namespace gms_ransac {

constexpr int kEdgeRadius = 7;  ///< pixels of the level, of the square in which directions are weighed

/// Keeps the corners round which the image varies in every direction: the smaller eigenvalue of the structure tensor
/// (Förstner & Gülch 1987) of the square is at least a twentieth of the larger one. FAST also fires on the steps of a
/// slanted edge. Every corner must lie more than kEdgeRadius pixels from the sides.
void removeEdgePoints(const Plane& image, std::vector<Corner>& corners);

}  // namespace gms_ransac
