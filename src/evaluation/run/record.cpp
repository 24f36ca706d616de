#include "run/record.h"

#include <cstdio>
#include <cstdlib>

#include <nlohmann/json.hpp>

namespace gms_ransac {

namespace {

using nlohmann::json;

/// The nearest double with nine significant digits: reads back as the same float, and prints short.
double shortest(float value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", static_cast<double>(value));
  return std::strtod(text, nullptr);
}

json toJson(const std::optional<MatchCounts>& counts) {
  if (!counts) return nullptr;
  return {{"raw_known", counts->raw_known},   {"raw_correct", counts->raw_correct},
          {"kept_known", counts->kept_known}, {"kept_correct", counts->kept_correct},
          {"raw_points", counts->raw_points}, {"kept_points", counts->kept_points}};
}

json toJson(const PairScore& score) {
  if (!score.has_true_pose && !score.epipolar && !score.transfer) return nullptr;
  json pose = nullptr;
  if (score.pose) pose = {{"rotation_deg", score.pose->rotation}, {"direction_deg", score.pose->direction}};
  return {{"pose_error", pose}, {"epipolar", toJson(score.epipolar)}, {"transfer", toJson(score.transfer)}};
}

json toJson(const StageTimes& times) {
  return {{"detect", 1e3 * times.detect},
          {"match", 1e3 * times.match},
          {"gms", 1e3 * times.gms},
          {"ransac", 1e3 * times.ransac},
          {"total", 1e3 * times.total()}};
}

json correspondencesJson(const std::vector<std::array<float, 6>>& correspondences) {
  json rows = json::array();
  for (const auto& correspondence : correspondences) {
    json row = json::array();
    for (const float value : correspondence) row.push_back(shortest(value));
    rows.push_back(row);
  }
  return rows;
}

void copyInliers(const Features& reference, const Features& current, const MatchResult& result, Record& record) {
  for (size_t i = 0; i < result.matches.size(); ++i) {
    if (result.stage[i] != MatchStage::kInlier) continue;
    const Match& match = result.matches[i];
    const cv::Point2f& p = reference.keypoints[static_cast<size_t>(match.reference)].pt;
    const cv::Point2f& q = current.keypoints[static_cast<size_t>(match.current)].pt;
    record.correspondences.push_back({p.x, p.y, q.x, q.y, result.confidence[i], result.probability[i]});
  }
}

}  // namespace

Record makeRecord(const RecordContext& context, const Features& reference, const Features& current,
                  const MatchResult& result, const PairTruth& truth) {
  Record record;
  record.context = context;
  record.status = toString(result.status);
  record.keypoints_reference = result.keypoints_reference;
  record.keypoints_current = result.keypoints_current;
  record.matches_raw = static_cast<int>(result.matches.size());
  record.matches_gms = result.matches_gms;
  record.inliers = result.inliers;
  record.hypotheses = result.robust.effort.hypotheses;
  record.models_scored = result.robust.effort.models_scored;
  record.point_evaluations = result.robust.effort.point_evaluations;
  record.has_pose = result.status == Status::kOk || result.status == Status::kLowParallax;
  record.R = result.robust.pose.R;
  record.t = result.robust.pose.t;
  record.median_parallax_px = result.robust.median_parallax_px;
  record.covariance = result.robust.pose.covariance;
  record.rms_error_px = result.robust.rms_error_px;
  record.sigma_px = result.robust.sigma_px;
  record.times = result.times;
  copyInliers(reference, current, result, record);

  PairScore& score = record.score;
  score.has_true_pose = truth.currentInReference().has_value();
  if (score.has_true_pose && record.has_pose) score.pose = poseError(*truth.currentInReference(), record.R, record.t);
  if (truth.hasEpipolar()) score.epipolar = countEpipolar(truth, reference, current, result);
  if (truth.hasTransfer()) score.transfer = countTransfer(truth, reference, current, result);
  return record;
}

std::string toJsonLine(const Record& record) {
  json line = {{"method", record.context.method},
               {"model", toString(record.context.model)},
               {"reference", record.context.reference},
               {"current", record.context.current},
               {"gap", nullptr},
               {"seed", record.context.seed},
               {"repeat", record.context.repeat},
               {"features", record.context.features},
               {"keypoints_reference", record.keypoints_reference},
               {"keypoints_current", record.keypoints_current},
               {"matches_raw", record.matches_raw},
               {"matches_gms", record.matches_gms},
               {"inliers", record.inliers},
               {"hypotheses", record.hypotheses},
               {"models_scored", record.models_scored},
               {"point_evaluations", record.point_evaluations},
               {"status", record.status},
               {"R", nullptr},
               {"t", nullptr},
               {"metric_scale", false},
               {"median_parallax_px", nullptr},
               {"rms_error_px", nullptr},
               {"sigma_px", nullptr},
               {"covariance", nullptr},
               {"times_ms", toJson(record.times)},
               {"truth", toJson(record.score)},
               {"correspondences", correspondencesJson(record.correspondences)}};
  if (record.context.gap > 0) line["gap"] = record.context.gap;
  if (record.inliers > 0) {
    line["rms_error_px"] = record.rms_error_px;
    line["sigma_px"] = record.sigma_px;
  }
  if (record.has_pose) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = record.R;
    line["R"] = std::vector<double>(R.data(), R.data() + 9);
    line["t"] = std::vector<double>(record.t.data(), record.t.data() + 3);
    line["median_parallax_px"] = record.median_parallax_px;
    // Symmetric: by columns is by rows.
    line["covariance"] = std::vector<double>(record.covariance.data(), record.covariance.data() + 36);
  }
  return line.dump();
}

}  // namespace gms_ransac
