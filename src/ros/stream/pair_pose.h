// The relative pose of a comparison -> the pose that is published: the length of its translation by ~scale, its
// least covariance, and the last look at it.
#pragma once

#include "gms_ransac/triangulation.h"
#include "stream/pipeline.h"
#include "stream/processed_frame.h"
#include "stream/stream.h"

namespace gms_ransac {

/// Fills pose, length and points of an answer from the rest of it. Depth may change LOW_PARALLAX to OK; a pose that is
/// unfit to publish becomes RANSAC_FAILED with the reason. Scale and key frame of the stream learn from it.
void findPose(const Pipeline& pipeline, Stream& stream, Triangulation& points, ProcessedFrame& answer);

}  // namespace gms_ransac
