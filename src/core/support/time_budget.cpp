#include "support/time_budget.h"

#include <algorithm>
#include <utility>

namespace gms_ransac {

namespace {

/// Describing a feature takes as long as finding corners in so many pixels: 79 with simd_orb, 66 with cv::ORB.
constexpr double kPixelsOfFeature = 75;
/// Step of a unit cost towards a pair's: constant, so that it becomes a median; larger at first.
constexpr double kStep = 0.03, kFirstStep = 1;
constexpr double kGrowth = 1.25;    ///< of the features from image to image at most; down they go at once
constexpr double kDeadBand = 0.05;  ///< they are not raised by less
/// Share of the budget that is set aside for samples at most. Most pairs are done after a fraction of it.
constexpr double kSearchShare = 0.2;
constexpr double kLastSample = 0.01;  ///< the same, for the sample during which time is up
constexpr int kFirstPairs = 2;        ///< that are not learnt from: their storage is new
constexpr double kFirstMargin = 1.25;
constexpr int kSpreadKnown = 20;  ///< pairs
constexpr double kDrift = 1.04;   ///< by which a machine becomes slower before it is noticed

/// Without samples, whose time has a limit of its own.
double takenBy(const PairCost& cost) { return cost.before + cost.extract + cost.match + cost.filter + cost.estimate; }

double extractionWork(double pixels, double features) { return pixels + kPixelsOfFeature * features; }

}  // namespace

TimeBudget::TimeBudget(double seconds, int features, Clock now) : seconds_(seconds), most_(features) {
  limit_.now = std::move(now);
}

double TimeBudget::margin() const {
  const int known = std::min(ratio_count_, kWindow);
  if (known < kSpreadKnown) return kFirstMargin;
  std::array<double, kWindow> sorted = ratios_;
  // One pair in a hundred may be late: leave out the largest ratio of two hundred.
  auto* at = sorted.begin() + (known - 1 - known / kWindow);
  std::nth_element(sorted.begin(), at, sorted.begin() + known);
  return kDrift * std::max(1.0, *at);
}

double TimeBudget::expected(const PairCost& pair) const {
  return costs_.before + costs_.extract * extractionWork(pair.pixels, pair.asked) +
         costs_.match * pair.reference * pair.current + (costs_.filter + costs_.estimate) * pair.current;
}

bool TimeBudget::hopeless(const PairCost& cost) const {
  PairCost fewest = cost;
  fewest.asked = std::min(kFewest, most_);
  fewest.reference = fewest.current = fewest.asked;
  const double stall = takenBy(cost) - expected(cost);
  return expected(fewest) + stall > seconds_;
}

int TimeBudget::features(const cv::Size& image) {
  std::lock_guard<std::mutex> lock(mutex_);
  const int fewest = std::min(kFewest, most_);
  if (pairs_ <= kFirstPairs) return asked_ = fewest;
  const double search = std::min(2 * costs_.search, kSearchShare * seconds_);
  const double room = (seconds_ - search) / margin();
  PairCost pair;
  pair.pixels = image.area();
  pair.reference = asked_;
  const auto fits = [&](int features) {
    pair.asked = features;
    pair.current = features;
    return expected(pair) <= room;
  };
  int fit = fewest, too_many = most_ + 1;
  while (too_many - fit > 1) {
    const int middle = (fit + too_many) / 2;
    (fits(middle) ? fit : too_many) = middle;
  }
  const bool raise = fit > (1 + kDeadBand) * asked_ || (fit == most_ && fit > asked_);
  if (raise) asked_ = std::min({fit, most_, static_cast<int>(kGrowth * asked_)});
  if (fit < asked_) asked_ = fit;
  return asked_;
}

void TimeBudget::limitSearch(double spent, int features) {
  std::lock_guard<std::mutex> lock(mutex_);
  const double now = limit_.now(), left = seconds_ - spent;
  const double after = margin() * costs_.estimate * features;
  limit_.search_until = now + left - after - kLastSample * seconds_;
  limit_.hurry_from = now + left - 0.5 * after;
}

void TimeBudget::record(const PairCost& cost) {
  std::lock_guard<std::mutex> lock(mutex_);
  const int known = pairs_++ - kFirstPairs;
  if (known < 0) return;
  if (known > 0 && cost.estimate > 0 && !hopeless(cost)) {
    const double taken = takenBy(cost);
    ratios_[static_cast<size_t>(ratio_count_++ % kWindow)] = taken / expected(cost);
  }
  const double step = 1 + std::max(kStep, kFirstStep / (known + 1));
  const auto adapt = [step](double taken, double work, double& unit_cost) {
    if (!(taken > 0 && work > 0)) return;
    const double unit = taken / work;
    unit_cost = unit_cost > 0 ? std::clamp(unit, unit_cost / step, unit_cost * step) : unit;
  };
  adapt(cost.before, 1, costs_.before);
  adapt(cost.extract, extractionWork(cost.pixels, cost.asked), costs_.extract);
  adapt(cost.match, cost.reference * cost.current, costs_.match);
  adapt(cost.filter, cost.current, costs_.filter);
  adapt(cost.search, 1, costs_.search);
  adapt(cost.estimate, cost.current, costs_.estimate);
}

}  // namespace gms_ransac
