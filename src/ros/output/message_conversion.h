// Results of an image -> messages.
#pragma once

#include <gms_ransac/Correspondences.h>
#include <gms_ransac/Keypoints.h>
#include <gms_ransac/MatchStats.h>

#include "stream/processed_frame.h"

namespace gms_ransac {

struct FrameCounters {
  uint32_t received = 0, processed = 0, passed_over = 0, dropped = 0, resets = 0;
};

/// `processed` must have been compared. With `with_rejected` every raw match is written and `stage` filled.
void toMessage(const ProcessedFrame& processed, bool with_rejected, Correspondences& message);

/// The features of the current image as they are. It must have been of use (not BAD_IMAGE).
void toMessage(const ProcessedFrame& processed, Keypoints& message);

/// Does not set the latency.
void toMessage(const ProcessedFrame& processed, const FrameCounters& counters, MatchStats& message);

}  // namespace gms_ransac
