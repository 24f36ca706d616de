#include "run/record.h"

#include <optional>
#include <set>
#include <variant>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "parameter.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using nlohmann::json;

/// The nearest double with nine significant digits: reads back as the same float, and prints short.
double shortest(float value) { return std::stod(cv::format("%.9g", static_cast<double>(value))); }

bool hasPose(const MatchResult& result) {
  return result.status == Status::kOk || result.status == Status::kLowParallax;
}

/// How many matches the truth confirms. Raw: all brute-force matches; kept: the inliers; known: where the truth has no
/// hole. Nearest neighbours share points, so the points of the current image with a correct match are counted, too.
template <typename Distance>
json countsRecord(const Features& reference, const Features& current, const MatchResult& result,
                  const Distance& distance) {
  int raw_known = 0, raw_correct = 0, kept_known = 0, kept_correct = 0;
  std::set<int> raw_points, kept_points;
  for (size_t i = 0; i < result.matches.size(); ++i) {
    const Match& match = result.matches[i];
    const std::optional<double> d = distance(reference.keypoints[static_cast<size_t>(match.reference)].pt,
                                             current.keypoints[static_cast<size_t>(match.current)].pt);
    if (!d) continue;
    const bool kept = result.stage[i] == MatchStage::kInlier, correct = *d < kCorrectWithin;
    ++raw_known;
    raw_correct += correct;
    kept_known += kept;
    kept_correct += kept && correct;
    if (correct) raw_points.insert(match.current);
    if (kept && correct) kept_points.insert(match.current);
  }
  return {{"raw_known", raw_known},       {"raw_correct", raw_correct},      {"kept_known", kept_known},
          {"kept_correct", kept_correct}, {"raw_points", raw_points.size()}, {"kept_points", kept_points.size()}};
}

}  // namespace

json answerRecord(const MatchFilterOptions& options, const MatchResult& result) {
  const RobustResult& robust = result.robust;
  const StageTimes& times = result.times;
  json record = {{"method", options.method},
                 {"model", toString(options.robust.model)},
                 {"features", options.extractor.features},
                 {"ratio", options.robust.first_group_fraction},
                 {"seed", options.robust.seed},
                 {"keypoints_reference", result.keypoints_reference},
                 {"keypoints_current", result.keypoints_current},
                 {"matches_raw", result.matches.size()},
                 {"matches_gms", result.matches_gms},
                 {"inliers", result.inliers},
                 {"hypotheses", robust.effort.hypotheses},
                 {"models_scored", robust.effort.models_scored},
                 {"point_evaluations", robust.effort.point_evaluations},
                 {"status", toString(result.status)},
                 {"stationary", result.stationary},
                 {"R", nullptr},
                 {"t", nullptr},
                 {"metric_scale", false},
                 {"median_parallax_px", nullptr},
                 {"rms_error_px", nullptr},
                 {"sigma_px", nullptr},
                 {"covariance", nullptr},
                 {"times_ms",
                  {{"detect", 1e3 * times.detect},
                   {"match", 1e3 * times.match},
                   {"gms", 1e3 * times.gms},
                   {"ransac", 1e3 * times.ransac},
                   {"total", 1e3 * times.total()}}}};
  if (result.inliers > 0) {
    record["rms_error_px"] = robust.rms_error_px;
    record["sigma_px"] = robust.sigma_px;
  }
  if (hasPose(result)) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = robust.pose.R;
    record["R"] = std::vector<double>(R.data(), R.data() + 9);
    record["t"] = std::vector<double>(robust.pose.t.data(), robust.pose.t.data() + 3);
    record["median_parallax_px"] = robust.median_parallax_px;
    // Symmetric: by columns is by rows.
    record["covariance"] = std::vector<double>(robust.pose.covariance.data(), robust.pose.covariance.data() + 36);
  }
  return record;
}

json poseRecord(const Eigen::Isometry3d& truth, const MatchResult& result) {
  const Eigen::Vector3d t = truth.translation();
  json record = {{"has_pose", true}, {"translation_m", {t.x(), t.y(), t.z()}}, {"pose_error", nullptr}};
  if (!hasPose(result)) return record;
  const RelativePose& pose = result.robust.pose;
  const PoseError error = poseError(truth, pose.R, pose.t);
  const Eigen::Vector3d rotation = kDegrees * rotationVector(pose.R * truth.linear().transpose());
  record["pose_error"] = {{"rotation_deg", error.rotation},
                          {"direction_deg", error.direction},
                          {"rotation_vector_deg", {rotation.x(), rotation.y(), rotation.z()}}};
  return record;
}

json truthRecord(const PairTruth& truth, const Features& reference, const Features& current,
                 const MatchResult& result) {
  const auto& pose = truth.currentInReference();
  if (!pose && !truth.hasEpipolar() && !truth.hasTransfer()) return nullptr;
  json record = pose ? poseRecord(*pose, result) : json{{"has_pose", false}, {"pose_error", nullptr}};
  record["epipolar"] = record["transfer"] = nullptr;
  const auto count = [&](const auto& distance) { return countsRecord(reference, current, result, distance); };
  if (truth.hasEpipolar()) {
    record["epipolar"] = count([&](const auto& p, const auto& q) { return truth.epipolarDistance(p, q); });
  }
  if (truth.hasTransfer()) {
    record["transfer"] = count([&](const auto& p, const auto& q) { return truth.transferDistance(p, q); });
  }
  return record;
}

json correspondencesRecord(const Features& reference, const Features& current, const MatchResult& result) {
  json rows = json::array();
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (result.stage[i] != MatchStage::kInlier) continue;
    const cv::Point2f& p = reference.keypoints[static_cast<size_t>(result.matches[i].reference)].pt;
    const cv::Point2f& q = current.keypoints[static_cast<size_t>(result.matches[i].current)].pt;
    json row = json::array();
    for (const float value : {p.x, p.y, q.x, q.y, result.confidence[i], result.probability[i]}) {
      row.push_back(shortest(value));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

json optionsRecord(const MatchFilterOptions& options) {
  json values;
  for (const auto& [name, value] : parametersOf(options)) {
    std::visit([&json_value = values[name]](const auto& typed) { json_value = typed; }, value);
  }
  return values;
}

}  // namespace gms_ransac
