// Says the same thing at most once in a while; one clock per sentence, so that one complaint cannot hide another.
#pragma once

#include <cstddef>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <string>

#include <ros/console.h>
#include <ros/time.h>

namespace gms_ransac {

/// Wall time, because simulated time may stand still or go back. May be used from any thread. What is remembered is
/// bounded: a sentence may quote a message, and messages may say something new each time.
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

  /// How many sentences are remembered.
  size_t size() {
    std::lock_guard<std::mutex> lock(mutex_);
    return quiet_until_.size();
  }

  void info(const std::string& key, const std::string& sentence) {
    if (due(key, period_)) ROS_INFO_STREAM(sentence);
  }

 private:
  bool due(const std::string& key, double period) {
    std::lock_guard<std::mutex> lock(mutex_);
    const double now = ros::WallTime::now().toSec();
    const auto said = quiet_until_.find(key);
    if (said != quiet_until_.end()) {
      if (now < said->second) return false;
      said->second = now + period;
      return true;
    }
    if (quiet_until_.size() >= kMostSentences) forgetExpired(now);
    if (quiet_until_.size() >= kMostSentences) return false;
    quiet_until_.emplace(key, now + period);
    return true;
  }

  void forgetExpired(double now) {
    for (auto entry = quiet_until_.begin(); entry != quiet_until_.end();) {
      entry = now < entry->second ? std::next(entry) : quiet_until_.erase(entry);
    }
  }

  // Of a period. The code has some twenty sentences; a stream of new ones would fill the log as well as the memory.
  static constexpr size_t kMostSentences = 100;

  const double period_;
  std::mutex mutex_;
  std::map<std::string, double> quiet_until_;  ///< by key: wall time, seconds
};

}  // namespace gms_ransac
