// Many records, one row of figures for each method.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "run/metrics.h"
#include "run/record.h"

namespace gms_ransac {

/// What is remembered of a record once its correspondences are written.
struct PairOutcome {
  bool has_true_pose = false, has_pose = false, ok = false;
  PoseError error;  ///< kFailedPoseError without a pose
  std::optional<MatchCounts> epipolar, transfer;
  int features = 0, matches_raw = 0, matches_gms = 0, inliers = 0;
  int hypotheses = 0, models_scored = 0;
  int64_t point_evaluations = 0;
  StageTimes times;
};
PairOutcome outcomeOf(const Record& record);

/// Figures over the outcomes of one method. Pose figures count every pair with a true pose (a missing pose is an error
/// of 180 degrees); kept, correct and precision are of the pairs that were answered. NaN: the truth does not cover it.
struct Summary {
  int pairs = 0, answered = 0, ok = 0;
  double auc5 = 0, auc10 = 0, auc20 = 0, rotation_auc2 = 0;  ///< percent
  double rotation_median = 0;                                ///< degrees, of the answered
  double precision = 0, recall = 0;                          ///< percent, means over pairs
  double kept = 0, correct = 0;                              ///< medians
  double paper_precision = 0, paper_recall = 0;              ///< percent, medians
  double hypotheses = 0, models_scored = 0, point_evaluations = 0;
  double detect_ms = 0, match_ms = 0, gms_ms = 0, ransac_ms = 0, total_ms = 0;  ///< medians
};
Summary summarize(const std::vector<PairOutcome>& outcomes);

/// Aligned text, one line a method.
std::string summaryTable(const std::vector<std::pair<std::string, Summary>>& rows);

}  // namespace gms_ransac
