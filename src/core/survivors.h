// Selects the raw matches that the filter hands to the estimator, and fills their columns.
#pragma once

#include <vector>

#include "gms_ransac/match_result.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

class SurvivorSelector {
 public:
  SurvivorSelector(bool one_to_one, bool with_image_rows)
      : one_to_one_(one_to_one), with_image_rows_(with_image_rows) {}

  /// Fills `matches`, `pairs` and `confidence` of the result with the accepted ones of `raw` whose rays are known; with
  /// MatchFilterOptions::one_to_one the best of each current point.
  void select(const Features& reference, const Features& current, const MotionStatistics& statistics,
              const Camera& camera, MatchResult& result);

  /// The same with all of `raw`, which are the caller's; those without rays have coordinates that are not numbers.
  void selectAll(const Features& reference, const Features& current, const Camera& camera, MatchResult& result);

 private:
  void keepOneForEachPoint(size_t current_points, const std::vector<Match>& raw, const MotionStatistics& statistics);

  bool one_to_one_, with_image_rows_;
  std::vector<int> kept_;  ///< raw match of each row
  std::vector<int> best_;  ///< raw match of each current point
};

}  // namespace gms_ransac
