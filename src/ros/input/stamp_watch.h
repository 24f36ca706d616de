// Classifies the images of a stream by their stamps and the clock: comparable, late, or the start of a new stream.
#pragma once

#include <utility>

#include "late_stamps.h"

namespace gms_ransac {

/// The further down, the more is forgotten.
enum class StampVerdict {
  kFirst,        ///< nothing came before
  kInOrder,      ///< compare with the image before
  kAfterLate,    ///< the same, but an image between was dropped as late: the clock may have been set back
  kOutOfOrder,   ///< not newer than the image before: drop it
  kGap,          ///< too long after the image before: a new reference
  kSteppedBack,  ///< the clock that stamps the images was set back by little: a new reference
  kJumpedBack,   ///< stamps restarted (a bag looped without --clock): a new reference
  kClockReset    ///< the node's clock itself went back (simulated time restarted): forget everything
};

/// The stamps begin anew: what was learnt from those before does not hold.
inline bool restarts(StampVerdict verdict) { return verdict > StampVerdict::kSteppedBack; }

class StampWatch {
 public:
  /// `stamp`: of the image; `now`: the node's clock when it arrived; `max_gap`; all in seconds. An image that is to be
  /// dropped does not move the watch. An image that is late by up to max_gap was overtaken; a second one, newer than
  /// the first, shows that the clock was set back. Larger steps, and any once the node's clock went back, are a stream
  /// that started again.
  ///
  /// Clock and images travel apart: at the start of a loop either may come first, and both together are one restart.
  StampVerdict judge(double stamp, double now, double max_gap) {
    if (!have_previous_) {
      have_previous_ = true;
      previous_stamp_ = stamp;
      previous_now_ = now;
      return StampVerdict::kFirst;
    }
    noteClock(now);
    const double step = stamp - previous_stamp_;
    const bool late = step <= 0 && step >= -max_gap && !clock_restarted_;
    if (late && (step == 0 || !late_.steppedBack(stamp))) return StampVerdict::kOutOfOrder;
    previous_stamp_ = stamp;
    if (late) return StampVerdict::kSteppedBack;
    const bool after_late = late_.end();
    if (step <= 0) return restart();
    // In order and not ahead of the new clock: the old stream has ended.
    if (stamp <= now) clock_restarted_ = false;
    if (step > max_gap) return StampVerdict::kGap;
    return after_late ? StampVerdict::kAfterLate : StampVerdict::kInOrder;
  }

  double previousStamp() const { return previous_stamp_; }
  void reset() { have_previous_ = false; }

 private:
  void noteClock(double now) {
    if (now < previous_now_) clock_restarted_ = !std::exchange(stamps_restarted_, false);
    previous_now_ = now;
  }

  StampVerdict restart() {
    const bool clock_came_first = std::exchange(clock_restarted_, false);
    stamps_restarted_ = !clock_came_first;
    return clock_came_first ? StampVerdict::kClockReset : StampVerdict::kJumpedBack;
  }

  bool have_previous_ = false;
  double previous_stamp_ = 0, previous_now_ = 0;
  LateStamps late_;
  bool clock_restarted_ = false;   ///< and the stamps have not yet
  bool stamps_restarted_ = false;  ///< and the clock has not yet
};

}  // namespace gms_ransac
