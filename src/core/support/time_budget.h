// ~max_milliseconds: how many features are asked for and how long the search may last, so that the time for an image is
// kept on a machine of unknown speed. See doc/inside/time_budget.md.
#pragma once

#include <array>
#include <functional>
#include <mutex>

#include <opencv2/core/types.hpp>

namespace gms_ransac {

using Clock = std::function<double()>;

struct TimeLimit {
  Clock now;
  double search_until = 0;  ///< no further sample is drawn from then on
  double hurry_from = 0;    ///< what follows the search is cut short when it begins after that

  bool late() const { return now() >= hurry_from; }
};

struct PairCost {
  double pixels = 0;                  ///< of the current image
  int asked = 0;                      ///< features of the current image
  double reference = 0, current = 0;  ///< features found
  double before = 0;                  ///< by the caller, for the image before it came
  double extract = 0, match = 0, filter = 0;
  double search = 0;    ///< of the estimator, in samples
  double estimate = 0;  ///< the rest of it
};

/// All functions may be called from any thread.
class TimeBudget {
 public:
  /// Fewer features are never asked for, unless the user does.
  static constexpr int kFewest = 300;

  TimeBudget(double seconds, int features, Clock now);

  int features(const cv::Size& image);
  /// Sets the limit for the estimator, which begins now, of a pair that has taken so many seconds so far.
  void limitSearch(double spent, int features);
  const TimeLimit& limit() const { return limit_; }
  void record(const PairCost& cost);

 private:
  struct UnitCosts {
    double before = 0, extract = 0, match = 0, filter = 0, search = 0, estimate = 0;
  };
  /// Ratio of time taken to expected that all but the late images keep.
  double margin() const;
  double expected(const PairCost& pair) const;
  /// True of a stall: late even with the fewest features.
  bool hopeless(const PairCost& cost) const;

  const double seconds_;
  const int most_;
  TimeLimit limit_;  ///< of the thread that estimates

  std::mutex mutex_;  ///< guards what follows
  UnitCosts costs_;
  int pairs_ = 0;  ///< learnt from
  int asked_ = 0;  ///< of the last image
  static constexpr int kWindow = 200;
  int ratio_count_ = 0;
  std::array<double, kWindow> ratios_{};  ///< time taken over time expected, of the last pairs
};

}  // namespace gms_ransac
