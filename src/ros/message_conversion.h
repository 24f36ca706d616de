// Answers of the core -> messages.
#pragma once

#include <gms_ransac/Correspondences.h>
#include <gms_ransac/MatchStats.h>

#include "frame_processor.h"

namespace gms_ransac {

struct FrameCounters {
  uint32_t received = 0, processed = 0, dropped = 0, resets = 0;
};

/// `answer` must have been compared. With `with_rejected` every raw match is written and `stage` filled.
void toMessage(const Answer& answer, bool with_rejected, Correspondences& message);

/// Latency is left at zero.
void toMessage(const Answer& answer, const FrameCounters& counters, MatchStats& message);

}  // namespace gms_ransac
