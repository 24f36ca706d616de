// Classifies the images of a stream by their stamps and the clock: comparable, late, or the start of a new stream.
#pragma once

#include <utility>

namespace gms_ransac {

/// The further down, the more is forgotten.
enum class StampVerdict {
  kFirst,       ///< nothing came before
  kInOrder,     ///< compare with the image before
  kOutOfOrder,  ///< not newer than the image before: drop it
  kGap,         ///< too long after the image before: a new reference
  kJumpedBack,  ///< stamps restarted (a bag looped without --clock): a new reference
  kClockReset   ///< the node's clock itself went back (simulated time restarted): forget everything
};

class StampWatch {
 public:
  /// `stamp`: of the image; `now`: the node's clock when it arrived; `max_gap`; all in seconds. An image that is to be
  /// dropped does not move the watch. Backward steps up to max_gap are taken for images that overtook each other,
  /// larger ones, and any once the clock went back, for a stream that started again.
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
    if (step <= 0 && step >= -max_gap && !clock_restarted_) return StampVerdict::kOutOfOrder;
    previous_stamp_ = stamp;
    if (step <= 0) return restart();
    // In order and not ahead of the new clock: the old stream has ended.
    if (stamp <= now) clock_restarted_ = false;
    return step > max_gap ? StampVerdict::kGap : StampVerdict::kInOrder;
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
  bool clock_restarted_ = false;   ///< and the stamps have not yet
  bool stamps_restarted_ = false;  ///< and the clock has not yet
};

}  // namespace gms_ransac
