// Tells a clock that was set back by little from messages that overtake each other.
#pragma once

#include <optional>
#include <utility>

namespace gms_ransac {

/// Messages overtake each other one at a time. After a step of the clock all that come are older than the newest before
/// it, and in order among themselves.
class LateStamps {
 public:
  /// Notes a stamp older than the newest. Returns true if the message before it was late, too, and older still.
  bool steppedBack(double stamp) {
    const bool stepped = last_ && stamp > *last_;
    last_ = stamp;
    if (stepped) last_.reset();
    return stepped;
  }
  /// Notes a stamp newer than all before it. Returns true if the message before it was late: a step of less than two
  /// intervals looks the same as one message that was overtaken.
  bool end() { return std::exchange(last_, std::nullopt).has_value(); }

 private:
  std::optional<double> last_;  ///< of the message before, if it was late
};

}  // namespace gms_ransac
