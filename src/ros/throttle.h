// Logs the same sentence at most once in a while; one clock per sentence, so that one warning cannot hide another. It
// is the same with other numbers in it.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <string>

#include <ros/console.h>
#include <ros/time.h>

namespace gms_ransac {

/// By the steady clock: simulated time may stand still or go back, wall time be set. May be used from any thread.
class Throttle {
 public:
  /// Said within the period at most; more than there are kinds of complaints. Sentences hold numbers out of messages,
  /// and a zooming camera has another focal length in each.
  static constexpr size_t kSentences = 32;

  /// `name`: of the node, the prefix of every line; empty: none.
  explicit Throttle(const std::string& name, double period_seconds = 10)
      : prefix_(name.empty() ? name : name + ": "), period_(period_seconds) {}

  /// Logs a warning unless the same with this key was logged within the period.
  void warn(const std::string& key, const std::string& sentence) {
    if (due(key + withoutNumbers(sentence), period_)) ROS_WARN_STREAM(prefix_ << sentence);
  }

  /// Logs a warning the first time this key comes.
  void warnOnce(const std::string& key, const std::string& sentence) {
    if (due(key, std::numeric_limits<double>::infinity())) ROS_WARN_STREAM(prefix_ << sentence);
  }

  void infoOnce(const std::string& key, const std::string& sentence) {
    if (due(key, std::numeric_limits<double>::infinity())) ROS_INFO_STREAM(prefix_ << sentence);
  }

  void error(const std::string& key, const std::string& sentence) {
    if (due(key + withoutNumbers(sentence), period_)) ROS_ERROR_STREAM(prefix_ << sentence);
  }

  void info(const std::string& key, const std::string& sentence) {
    if (due(key + withoutNumbers(sentence), period_)) ROS_INFO_STREAM(prefix_ << sentence);
  }

  /// Number of sentences that wait for their time, or were logged for good.
  size_t remembered() {
    std::lock_guard<std::mutex> lock(mutex_);
    return silent_until_.size();
  }

 private:
  static std::string withoutNumbers(std::string sentence) {
    const auto isDigit = [](unsigned char c) { return std::isdigit(c) != 0; };
    sentence.erase(std::remove_if(sentence.begin(), sentence.end(), isDigit), sentence.end());
    return sentence;
  }
  bool due(const std::string& key, double period) {
    std::lock_guard<std::mutex> lock(mutex_);
    const double now = ros::SteadyTime::now().toSec();
    for (auto each = silent_until_.begin(); each != silent_until_.end();) {
      each = each->second <= now ? silent_until_.erase(each) : std::next(each);
    }
    return silent_until_.size() < kSentences && silent_until_.emplace(key, now + period).second;
  }

  const std::string prefix_;
  const double period_;
  std::mutex mutex_;
  std::map<std::string, double> silent_until_;  ///< key -> steady time, seconds
};

}  // namespace gms_ransac
