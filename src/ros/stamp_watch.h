// Which images of a stream may be compared, judged by their stamps and the clock. Knows no topic.
#pragma once

namespace gms_ransac {

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
  /// larger ones for a stream that started again.
  StampVerdict judge(double stamp, double now, double max_gap) {
    const bool clock_went_back = have_previous_ && now < previous_now_;
    previous_now_ = now;
    if (!have_previous_ || clock_went_back) {
      const StampVerdict verdict = have_previous_ ? StampVerdict::kClockReset : StampVerdict::kFirst;
      have_previous_ = true;
      previous_stamp_ = stamp;
      return verdict;
    }
    const double step = stamp - previous_stamp_;
    if (step <= 0 && step >= -max_gap) return StampVerdict::kOutOfOrder;
    previous_stamp_ = stamp;
    if (step <= 0) return StampVerdict::kJumpedBack;
    return step > max_gap ? StampVerdict::kGap : StampVerdict::kInOrder;
  }

  double previousStamp() const { return previous_stamp_; }
  void reset() { have_previous_ = false; }

 private:
  bool have_previous_ = false;
  double previous_stamp_ = 0, previous_now_ = 0;
};

}  // namespace gms_ransac
