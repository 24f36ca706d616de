// Answers of the core -> messages.
#pragma once

#include <gms_ransac/Correspondences.h>
#include <gms_ransac/MatchStats.h>

#include "frame_processor.h"

namespace gms_ransac {

struct FrameCounters {
  uint32_t received = 0, processed = 0, dropped = 0, resets = 0;
};

/// Least standard deviations of a published pose, per axis.
struct SigmaFloor {
  double translation = 0.005;  ///< in units of the translation
  double rotation = 0.0005;    ///< radians
};

/// The pose as it may be published: an unobservable direction of translation is left out (zero) and its variance
/// large, the covariance is floored, finite, and its diagonal within what robot_localization accepts.
RelativePose publishablePose(const RobustResult& robust, const SigmaFloor& floor);

/// `answer` must have been compared. With `with_rejected` every raw match is written and `stage` filled.
void toMessage(const Answer& answer, const SigmaFloor& floor, bool with_rejected, Correspondences& message);

/// Latency is left at zero.
void toMessage(const Answer& answer, const FrameCounters& counters, MatchStats& message);

}  // namespace gms_ransac
