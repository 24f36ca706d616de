#include "run/record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <variant>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "parameters/parameter.h"
#include "program.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

using nlohmann::json;

constexpr size_t kBins = 10;  ///< of the probability of a match, of equal width

bool hasPose(const MatchResult& result) {
  return result.status == Status::kOk || result.status == Status::kLowParallax;
}

/// How many matches the truth confirms. Raw: all matches; kept: the inliers; known: where the truth has no hole.
/// Nearest neighbours share points, so the points of the current image with a correct match are counted, too.
struct Counts {
  int raw_known = 0, raw_correct = 0, kept_known = 0, kept_correct = 0;
  std::set<int> raw_points, kept_points;

  void add(int point, bool kept, bool correct) {
    ++raw_known;
    raw_correct += correct;
    kept_known += kept;
    kept_correct += kept && correct;
    if (correct) raw_points.insert(point);
    if (kept && correct) kept_points.insert(point);
  }
  json record() const {
    return {{"raw_known", raw_known},       {"raw_correct", raw_correct},      {"kept_known", kept_known},
            {"kept_correct", kept_correct}, {"raw_points", raw_points.size()}, {"kept_points", kept_points.size()}};
  }
};

/// Matches by their probability, in ten bins: count, sum of probabilities and count of right ones of each.
struct Reliability {
  std::array<double, 3 * kBins> numbers{};

  void add(float probability, bool right) {
    const double clamped = std::clamp(static_cast<double>(probability), 0.0, 1.0);
    double* bin = &numbers[3 * std::min(kBins - 1, static_cast<size_t>(clamped * kBins))];
    ++bin[0];
    bin[1] += clamped;
    bin[2] += right;
  }
  json record() const {
    auto rounded = numbers;
    for (double& number : rounded) number = std::round(1e4 * number) / 1e4;
    return rounded;
  }
};

template <typename Matrix>
std::vector<double> numbersOf(const Matrix& matrix) {  // by columns
  return std::vector<double>(matrix.data(), matrix.data() + matrix.size());
}

/// All that the probabilities were computed from, for fitting their weights: evidence by name, NaN as null, and the two
/// motions that may be published.
json judgementRecord(const Judgement& judgement) {
  json record, evidence;
  for (size_t k = 0; k < EvidenceTable::kSize; ++k) {
    const auto kind = static_cast<Evidence>(k);
    const double value = judgement.evidence[kind];
    evidence[toString(kind)] = std::isfinite(value) ? json(value)
                               : std::isnan(value)  ? json()
                                                    : json(value < 0 ? -1e9 : 1e9);
  }
  record["evidence"] = evidence;
  record["motion_R"] = numbersOf(Eigen::Matrix3d(judgement.motion.R.transpose()));
  record["motion_t"] = numbersOf(judgement.motion.t);
  record["rotation_R"] = numbersOf(Eigen::Matrix3d(judgement.rotation.R.transpose()));
  record["rotation_t"] = numbersOf(judgement.rotation.t);
  return record;
}

json answerRecord(const MatchFilterOptions& options, const MatchResult& result) {
  const RobustResult& robust = result.robust;
  const StageTimes& times = result.times;
  json record = {{"method", options.method},
                 {"order", findMethod(options.method).ordered ? "confidence" : "uniform"},
                 {"model", toString(options.robust.model)},
                 {"features", options.extractor.features},
                 {"ratio", options.robust.first_group_fraction},
                 {"seed", options.robust.seed},
                 {"keypoints_reference", result.keypoints_reference},
                 {"keypoints_current", result.keypoints_current},
                 {"matches_raw", result.raw.size()},
                 {"matches_gms", result.size()},
                 {"inliers", result.inliers},
                 {"hypotheses", robust.effort.hypotheses},
                 {"models_scored", robust.effort.models_scored},
                 {"point_evaluations", robust.effort.point_evaluations},
                 {"status", toString(result.status)},
                 {"stationary", result.stationary},
                 {"masked", result.mask.share()},
                 {"shutter",
                  {{"kind", toString(result.shutter.kind)},
                   {"readout", result.shutter.readout},
                   {"deviation", result.shutter.deviation}}},
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
    record["sigma_px"] = robust.judgement.sigma_px;
  }
  if (robust.judgement.pose_found) {
    // The likeliest motion is kept where no pose is known.
    const RelativePose& pose = hasPose(result) ? robust.judgement.pose : robust.judgement.motion;
    record["R"] = numbersOf(Eigen::Matrix3d(pose.R.transpose()));
    record["t"] = numbersOf(pose.t);
    record["median_parallax_px"] = robust.judgement.median_parallax_px;
    record["covariance"] = numbersOf(pose.covariance);
  }
  if (robust.judgement.pose_found && options.robust.judge) record["judgement"] = judgementRecord(robust.judgement);
  record["pose_probability"] = robust.judgement.pose_probability;
  record["rotation_probability"] = robust.judgement.rotation_probability;
  return record;
}

/// Errors of the pose, degrees: its angle of rotation, its rotation vector (estimate against truth) and the angle
/// between the translations. Noise of the true pose: covariances row by row, in radians and metres, and what of it is
/// the translation's own.
json truthRecord(const std::optional<Eigen::Isometry3d>& pose, const MatchResult& result, const TruthNoise& noise,
                 const PairNoise& pair_noise) {
  json record = {{"has_pose", pose.has_value()}};
  record["pose_error"] = record["noise"] = record["epipolar"] = record["transfer"] = nullptr;
  if (!pose) return record;
  record["translation_m"] = numbersOf(Eigen::Vector3d(pose->translation()));
  record["R"] = numbersOf(Eigen::Matrix3d(pose->linear().transpose()));
  record["moved"] = hasMoved(pose->translation().norm(), noise);
  if (!noise.exact()) {
    record["noise"] = {{"rotation", numbersOf(pair_noise.rotation)},
                       {"translation", numbersOf(pair_noise.translation)},
                       {"translation_sigma", noise.translation}};
  }
  if (!hasPose(result)) return record;
  const RelativePose& estimate = result.robust.judgement.pose;
  const PoseError error = poseError(*pose, estimate.R, estimate.t);
  const Eigen::Vector3d rotation = kDegrees * rotationVector(estimate.R * pose->linear().transpose());
  record["pose_error"] = {{"rotation_deg", error.rotation},
                          {"direction_deg", error.direction},
                          {"rotation_vector_deg", numbersOf(rotation)}};
  return record;
}

/// Returns true if the points of a drawn match are within kCorrectWithin of their true displacement.
bool isRight(const TwoViewScene& scene, size_t match) {
  const PointPairs& pairs = scene.pairs;
  const Eigen::Vector2d reference(pairs.x_reference[match], pairs.y_reference[match]);
  const Eigen::Vector2d current(pairs.x_current[match], pairs.y_current[match]);
  return (current - reference - scene.displacements[match]).norm() < kCorrectWithin;
}

const cv::Point2f& pointOf(const Features& features, int keypoint) {
  return features.keypoints[static_cast<size_t>(keypoint)].pt;
}

}  // namespace

double shortest(float value) {
  const double exact = value, size = std::abs(exact);
  if (size < 1e-4 || size >= 1e9) return std::stod(cv::format("%.9g", exact));
  // The product is exact, as 24 bits of a float and the 28 of 5^12 fit into a double.
  double scale = 1;
  while (size * scale < 1e8) scale *= 10;
  return std::nearbyint(exact * scale) / scale;
}

json recordOf(const Answer& answer) {
  const MatchResult& result = answer.result;
  const PairTruth& truth = answer.truth;
  Counts epipolar, transfer;
  Reliability reliability;
  const bool weighed = !result.robust.judgement.probability.empty();  // with a model
  result.forEachRaw([&](const Match& match, MatchStage stage, size_t row) {
    const cv::Point2f& p = pointOf(answer.reference, match.reference);
    const cv::Point2f& q =
        stage == MatchStage::kRaw ? pointOf(answer.current, match.current) : result.current_pixel[row];
    const bool kept = stage == MatchStage::kInlier;
    if (truth.hasEpipolar()) epipolar.add(match.current, kept, truth.epipolarDistance(p, q) < kCorrectWithin);
    const std::optional<double> distance = truth.hasTransfer() ? truth.transferDistance(p, q) : std::nullopt;
    if (distance) transfer.add(match.current, kept, *distance < kCorrectWithin);
    if (!weighed || stage == MatchStage::kRaw) return;
    if (const std::optional<bool> right = truth.label(p, q)) reliability.add(result.probability(row), *right);
  });
  json record = answerRecord(answer.options, result);
  record["reliability"] = reliability.record();
  record["truth"] = nullptr;
  const auto& pose = truth.currentInReference();
  if (!pose && !truth.hasEpipolar() && !truth.hasTransfer()) return record;
  json& known = record["truth"] = truthRecord(pose, result, truth.noise(), truth.pairNoise());
  if (truth.hasEpipolar()) known["epipolar"] = epipolar.record();
  if (truth.hasTransfer()) known["transfer"] = transfer.record();
  return record;
}

json recordOf(const MatchFilterOptions& options, Method& method, const TwoViewScene& scene) {
  MatchResult result;
  const double start = secondsOf(CLOCK_MONOTONIC);
  method.estimate(scene.pairs, scene.camera, result.robust);
  result.times.ransac = secondsOf(CLOCK_MONOTONIC) - start;
  result.status = statusOf(result.robust, scene.camera);
  result.matches.resize(scene.correct.size());
  result.inlier = result.robust.inlier;
  result.inliers = result.robust.inlier_count;
  Counts counts;
  Reliability reliability;
  for (size_t match = 0; match < scene.correct.size(); ++match) {
    counts.add(static_cast<int>(match), result.robust.inlier[match] != 0, scene.correct[match] != 0);
    if (!result.robust.judgement.probability.empty())
      reliability.add(result.robust.judgement.probability[match], isRight(scene, match));
  }
  json record = answerRecord(options, result);
  record["kind"] = "drawn";
  record["reliability"] = reliability.record();
  record["truth"] = truthRecord(scene.currentInReference(), result, {}, {});
  record["truth"]["transfer"] = counts.record();
  return record;
}

json recordOf(const MatchFilterOptions& options, const MatchResult& result,
              const Eigen::Isometry3d& current_in_reference) {
  json record = answerRecord(options, result);
  record["kind"] = "sequence";
  record["reliability"] = Reliability().record();
  record["truth"] = truthRecord(current_in_reference, result, {}, {});
  return record;
}

json correspondencesOf(const Answer& answer) {
  const MatchResult& result = answer.result;
  json inliers = json::array();
  for (size_t row = 0; row < result.matches.size(); ++row) {
    if (!result.isInlier(row)) continue;
    const cv::Point2f& p = pointOf(answer.reference, result.matches[row].reference);
    const cv::Point2f& q = result.current_pixel[row];
    json inlier = json::array();
    for (const float value : {p.x, p.y, q.x, q.y, result.confidence[row], result.probability(row)}) {
      inlier.push_back(shortest(value));
    }
    inliers.push_back(std::move(inlier));
  }
  return inliers;
}

json optionsRecord(const MatchFilterOptions& options) {
  json values;
  for (const auto& [name, value] : parametersOf(options)) {
    std::visit([&json_value = values[name]](const auto& typed) { json_value = typed; }, value);
  }
  return values;
}

}  // namespace gms_ransac
