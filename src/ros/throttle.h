// Says the same thing at most once in a while; one clock per sentence, so that one complaint cannot hide another.
#pragma once

#include <map>
#include <string>

#include <ros/console.h>
#include <ros/time.h>

namespace gms_ransac {

/// Wall time, because simulated time may stand still or go back.
class Throttle {
 public:
  explicit Throttle(double period_seconds = 10) : period_(period_seconds) {}

  /// Logs a warning unless one with this key was logged within the period.
  void warn(const std::string& key, const std::string& sentence) {
    const ros::WallTime now = ros::WallTime::now();
    const auto [entry, is_new] = last_.emplace(key, now);
    if (!is_new && now - entry->second < period_) return;
    entry->second = now;
    ROS_WARN_STREAM(sentence);
  }

 private:
  ros::WallDuration period_;
  std::map<std::string, ros::WallTime> last_;
};

}  // namespace gms_ransac
