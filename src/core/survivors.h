// Selects the raw matches that the filter hands to the estimator.
#pragma once

#include <vector>

#include "gms_ransac/match_result.h"
#include "gms_ransac/motion_statistics.h"

namespace gms_ransac {

class SurvivorSelector {
 public:
  SurvivorSelector(bool one_to_one, bool with_rows) : one_to_one_(one_to_one), with_rows_(with_rows) {}

  /// Fills `survivors` with accepted matches whose rays are known; with MatchFilterOptions::one_to_one the best of each
  /// current point.
  void select(const Features& reference, const Features& current, const std::vector<Match>& matches,
              const MotionStatistics& statistics, const Camera& camera, Survivors& survivors);

 private:
  void keepOneForEachPoint(size_t current_points, const std::vector<Match>& matches, const MotionStatistics& statistics,
                           std::vector<int>& survivors);

  bool one_to_one_, with_rows_;
  std::vector<int> best_;  ///< survivor of each current point
};

}  // namespace gms_ransac
