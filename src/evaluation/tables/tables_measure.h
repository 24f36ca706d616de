// The measurements behind the tables: one pipeline on one pair at one preset, repeated over seeds.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "tables/tables_plan.h"

namespace gms_ransac {

/// One pipeline on one pair at one preset. Columns have one entry for each repetition of the robust stage; the stages
/// before it do not depend on the seed.
struct Measurement {
  int unit = 0;
  std::string sequence, pair;  ///< pair: names of the two images
  int preset = 0;
  std::string method, model;
  double ratio = kPaperRatio;
  int matches_raw = 0, matches_gms = 0;
  double detect_ms = 0, match_ms = 0, gms_ms = 0;  ///< the fastest of several runs
  int raw_points = -1;                          ///< current points of correct raw matches; -1: the truth says nothing
  std::vector<double> inliers, known, correct;  ///< known: inliers the truth judges; correct: those it confirms
  std::vector<double> points;                   ///< current points of correct inliers
  std::vector<double> hypotheses, models_scored, point_evaluations, ransac_ms;  ///< processor time
  std::vector<double> rotation_error, pose_error;  ///< degrees, 180 without a pose; empty without a true pose
};

class TablesMeter {
 public:
  TablesMeter(const TablesPlan& plan, const std::vector<Dataset>& datasets);
  /// Every run of the unit, the repetitions interleaved over the runs so that a disturbance meets all alike.
  std::vector<Measurement> measure(const TablesUnit& unit);

 private:
  MatchFilter& filterFor(const TablesRun& run);

  const TablesPlan& plan_;
  const std::vector<Dataset>& datasets_;
  /// By method, model and ratio; kept, so that stages are warm.
  std::map<std::tuple<std::string, ModelType, double>, std::unique_ptr<MatchFilter>> filters_;
};

}  // namespace gms_ransac
