// Says the same thing at most once in a while; one clock per sentence, so that one complaint cannot hide another.
#pragma once

#include <limits>
#include <map>
#include <mutex>
#include <string>

#include <ros/console.h>
#include <ros/time.h>

namespace gms_ransac {

/// Wall time, because simulated time may stand still or go back. May be used from any thread.
class Throttle {
 public:
  explicit Throttle(double period_seconds = 10) : period_(period_seconds) {}

  /// Logs a warning unless one with this key was logged within the period.
  void warn(const std::string& key, const std::string& sentence) {
    if (due(key, period_)) ROS_WARN_STREAM(sentence);
  }

  /// Logs a warning the first time this key comes.
  void warnOnce(const std::string& key, const std::string& sentence) {
    if (due(key, std::numeric_limits<double>::infinity())) ROS_WARN_STREAM(sentence);
  }

  void info(const std::string& key, const std::string& sentence) {
    if (due(key, period_)) ROS_INFO_STREAM(sentence);
  }

 private:
  bool due(const std::string& key, double period) {
    std::lock_guard<std::mutex> lock(mutex_);
    const double now = ros::WallTime::now().toSec();
    const auto [entry, is_new] = last_.emplace(key, now);
    if (!is_new && now - entry->second < period) return false;
    entry->second = now;
    return true;
  }

  const double period_;
  std::mutex mutex_;
  std::map<std::string, double> last_;  ///< key -> wall time, seconds
};

}  // namespace gms_ransac
