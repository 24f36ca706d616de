// ~max_milliseconds: how many features are asked for and how long the search may last, so that the time for an image is
// kept on a machine of unknown speed. What it rests on: doc/time_budget.md.
#pragma once

#include <array>
#include <mutex>

#include <opencv2/core/types.hpp>

#include "gms_ransac/time_limit.h"

namespace gms_ransac {

/// What one pair of images was and took, in seconds; 0: that stage was not reached.
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

  double now() const { return limit_.now(); }
  double seconds() const { return seconds_; }
  /// How many to ask of the next image.
  int features(const cv::Size& image);
  /// Sets the limit for the estimator, which begins now, of a pair that has taken so many seconds so far.
  void limitSearch(double spent, int features);
  const TimeLimit& limit() const { return limit_; }
  /// A pair is done.
  void learn(const PairCost& cost);

 private:
  /// By the stages' own measures of work, their medians.
  struct UnitCosts {
    double before = 0, extract = 0, match = 0, filter = 0, search = 0, estimate = 0;
  };
  /// What took less than the share of all images that may be late.
  double margin() const;
  double expected(const PairCost& pair) const;
  /// It was late, and would have been with the fewest features, too: a stall, which says nothing of how many to ask
  /// for.
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
