// The record of an answer as one JSON object: options, result, and errors against the truth. scripts/evaluate_report.py
// computes all statistics and tables from records.
#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "gms_ransac/match_filter.h"
#include "methods/method.h"
#include "run/truth.h"
#include "scenes/two_view_scene.h"

namespace gms_ransac {

/// Version of the fields. A folder of measurements is resumed only with the same version.
constexpr int kRecordFormat = 5;

/// One pipeline's answer to a pair of images.
struct Answer {
  const MatchFilterOptions& options;
  const Features &reference, &current;
  const MatchResult& result;
  const PairTruth& truth;
};

/// Options, counts, effort, pose and times (milliseconds) of an answer; `truth`: errors of the pose, noise of the true
/// one, and counts of correct matches; `reliability`: matches by their probability. Fields without a value are null.
/// Pixels are those of the received image.
nlohmann::json recordOf(const Answer& answer);

/// The same of a method's answer to a drawn scene; `transfer` counts the matches by their exact labels.
nlohmann::json recordOf(const MatchFilterOptions& options, Method& method, const TwoViewScene& scene);

/// The same of an answer to two images of a drawn sequence, without labels of the matches.
nlohmann::json recordOf(const MatchFilterOptions& options, const MatchResult& result,
                        const Eigen::Isometry3d& current_in_reference);

/// The nearest double with nine significant digits: reads back as the same float, and prints short.
double shortest(float value);

/// u_reference, v_reference, u_current, v_current, confidence and probability of each inlier.
nlohmann::json correspondencesOf(const Answer& answer);

/// Every parameter of the core by its name.
nlohmann::json optionsRecord(const MatchFilterOptions& options);

}  // namespace gms_ransac
