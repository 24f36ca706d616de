// Stamped samples of the last seconds, in order, and whether they cover a time between two images.
#pragma once

#include <algorithm>
#include <deque>
#include <string>

#include "text.h"

namespace gms_ransac {

/// `Sample` has a `stamp` in seconds.
template <typename Sample>
class SampleBuffer {
 public:
  /// Adds a sample in the order of stamps. Ignores one that is not newer; one more than kRestart older than the newest
  /// starts a new stream and empties the buffer.
  void add(const Sample& sample) {
    if (!samples_.empty() && sample.stamp <= samples_.back().stamp) {
      if (samples_.back().stamp - sample.stamp < kRestart) return;
      samples_.clear();
    }
    samples_.push_back(sample);
    while (samples_.front().stamp < sample.stamp - kSeconds) samples_.pop_front();
  }
  void clear() { samples_.clear(); }
  bool empty() const { return samples_.empty(); }
  /// Everything up to this time has come.
  bool reaches(double stamp) const { return !empty() && samples_.back().stamp >= stamp; }

  static constexpr double kRestart = 1;   ///< seconds
  static constexpr double kSeconds = 30;  ///< kept

 protected:
  /// Index of the first sample later than `stamp`, at least 1 and at most the last. Needs a sample.
  size_t after(double stamp) const {
    const auto later = [](double time, const Sample& sample) { return time < sample.stamp; };
    const auto found = std::upper_bound(samples_.begin(), samples_.end(), stamp, later);
    return std::min(std::max<size_t>(1, static_cast<size_t>(found - samples_.begin())), samples_.size() - 1);
  }
  /// Returns what is missing at the ends of the interval, as the end of a sentence; empty: nothing. Needs a sample.
  std::string missing(double from, double to) const {
    if (samples_.back().stamp < to)
      return "the newest sample is " + secondsText(to - samples_.back().stamp) + " too old";
    if (samples_.front().stamp > from)
      return "the samples start " + secondsText(samples_.front().stamp - from) + " later";
    return std::string();
  }
  /// The same of a step between two samples that is too long.
  static std::string missingStep(double seconds) {
    return "no sample came for " + secondsText(seconds) + " between them";
  }

  std::deque<Sample> samples_;
};

}  // namespace gms_ransac
