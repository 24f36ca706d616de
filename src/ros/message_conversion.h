// What was found out about an image -> messages.
#pragma once

#include <gms_ransac/Correspondences.h>
#include <gms_ransac/MatchStats.h>

#include "frame_processor.h"

namespace gms_ransac {

struct FrameCounters {
  uint32_t received = 0, processed = 0, dropped = 0, resets = 0;
};

/// `processed` must have been compared. With `with_rejected` every raw match is written and `stage` filled.
void toMessage(const ProcessedFrame& processed, bool with_rejected, Correspondences& message);

/// Latency is left at zero.
void toMessage(const ProcessedFrame& processed, const FrameCounters& counters, MatchStats& message);

}  // namespace gms_ransac
