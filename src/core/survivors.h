// Which raw matches go on from the filter to the estimator, and as what.
#pragma once

#include <vector>

#include "gms_ransac/match_filter.h"

namespace gms_ransac {

class SurvivorSelector {
 public:
  /// `with_rows`: PointPairs::row_reference and row_current are wanted.
  SurvivorSelector(bool one_to_one, bool with_rows) : one_to_one_(one_to_one), with_rows_(with_rows) {}

  /// Fills `survivors` with the matches that the statistics accept and whose rays the calibration knows; of those with
  /// one current point only the best where that is wanted (MatchFilterOptions::one_to_one).
  void select(const Features& reference, const Features& current, const std::vector<Match>& matches,
              const MotionStatistics& statistics, const Camera& camera, Survivors& survivors);

 private:
  /// Leaves one of the survivors that share a current point.
  void keepOneForEachPoint(size_t current_points, const std::vector<Match>& matches, const MotionStatistics& statistics,
                           std::vector<int>& survivors);

  bool one_to_one_, with_rows_;
  std::vector<int> best_;  ///< survivor of each current point
};

}  // namespace gms_ransac
