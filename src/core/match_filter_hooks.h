// Access to a MatchFilter for tests and statistics.
#pragma once

#include <cstdint>
#include <functional>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

struct MatchFilterHooks {
  /// Replaces the clock of `times` and max_milliseconds.
  static void setClock(MatchFilter& filter, const std::function<double()>& seconds);
  static void setSeed(MatchFilter& filter, uint64_t seed);
  /// Estimates again from the matches in `result`: those that MatchFilter::filter left, or those of the caller.
  static void estimate(MatchFilter& filter, const Frame& reference, const Frame& current, MatchResult& result);
};

}  // namespace gms_ransac
