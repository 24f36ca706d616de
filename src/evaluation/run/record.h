// The record of a pair as one JSON object: options, result, and errors against the truth. scripts/evaluate_report.py
// computes all statistics and tables from records.
#pragma once

#include <string>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "gms_ransac/match_filter.h"
#include "run/pair_truth.h"

namespace gms_ransac {

/// Version of the fields. A folder of measurements is resumed only with the same version.
constexpr int kRecordFormat = 3;

/// Options, counts, effort, pose and times (milliseconds) of one answer. Fields without a value are null. Pixels are
/// those of the received image.
nlohmann::json answerRecord(const MatchFilterOptions& options, const MatchResult& result);

/// The true translation, metres, and the errors of the pose, degrees: its angle of rotation, its rotation vector
/// (estimate against truth) and the angle between the translations.
nlohmann::json poseRecord(const Eigen::Isometry3d& truth, const MatchResult& result);

/// Pose errors and counts of correct matches of an answer; null without a truth.
nlohmann::json truthRecord(const PairTruth& truth, const Features& reference, const Features& current,
                           const MatchResult& result);

/// u_reference, v_reference, u_current, v_current, confidence and probability of each inlier.
nlohmann::json correspondencesRecord(const Features& reference, const Features& current, const MatchResult& result);

/// Every parameter of the core by its name.
nlohmann::json optionsRecord(const MatchFilterOptions& options);

}  // namespace gms_ransac
