// Conditions that every result meets, for any input: asserted by the fuzz targets and by unit tests. Each function
// returns the violated condition in words, or an empty string.
#pragma once

#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/triangulation.h"
#include "tracks/track_table.h"

namespace gms_ransac {

/// Limit of the largest deviation of R^T R from the identity.
constexpr double kRotationRounding = 1e-9;
/// Limits of the asymmetry and the least eigenvalue of a correlation matrix, as published and as estimated. An
/// estimate's covariance is the inverse of a matrix that may be ill-conditioned (pair_pose.cpp).
constexpr double kPublishedRounding = 1e-6, kEstimateRounding = 1e-3;

/// `covariance` with its variances brought to one, which is what definiteness is judged by: entries of t and of the
/// rotation differ by many orders of magnitude.
inline std::string brokenCovariance(const Covariance6d& covariance, double rounding) {
  if (!covariance.allFinite()) return "a covariance is not finite";
  Eigen::Matrix<double, 6, 1> scale;
  for (int i = 0; i < 6; ++i) {
    if (covariance(i, i) < 0) return "a variance is negative";
    scale(i) = covariance(i, i) > 0 ? 1 / std::sqrt(covariance(i, i)) : 0;
  }
  const Eigen::Matrix<double, 6, 6> correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  if (!(correlation - correlation.transpose()).isZero(rounding)) return "a covariance is not symmetric";
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(correlation, Eigen::EigenvaluesOnly);
  if (!(solver.eigenvalues()(0) >= -rounding)) return "a covariance is not positive semi-definite";
  return std::string();
}

inline std::string brokenPose(const RelativePose& pose, double rounding = kEstimateRounding) {
  if (!pose.R.allFinite() || !pose.t.allFinite()) return "a pose is not finite";
  if (!(pose.R.transpose() * pose.R).isIdentity(kRotationRounding)) return "a rotation is not orthonormal";
  if (!(pose.R.determinant() > 0)) return "a rotation mirrors";
  return brokenCovariance(pose.covariance, rounding);
}

inline std::string brokenFeatures(const Features& features, const FeatureExtractorOptions& options) {
  if (features.descriptors.size() != features.size()) return "keypoints and descriptors differ in number";
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    const cv::Point2f& p = keypoint.pt;
    const bool inside = p.x >= 0 && p.y >= 0 && p.x <= static_cast<float>(features.image_size.width - 1) &&
                        p.y <= static_cast<float>(features.image_size.height - 1);
    if (!inside) return "a keypoint lies outside the image";
    if (keypoint.octave < 0 || keypoint.octave >= options.pyramid_levels) return "a keypoint has no level";
    if (!(keypoint.angle >= 0 && keypoint.angle <= 360)) return "a keypoint has no angle";
    if (!std::isfinite(keypoint.response)) return "a response is not finite";
  }
  return std::string();
}

inline std::string brokenStatistics(const MotionStatistics& statistics, size_t matches) {
  if (statistics.accepted.size() != matches || statistics.score.size() != matches ||
      statistics.relative_score.size() != matches || statistics.cell.size() != matches ||
      (!statistics.log_odds.empty() && statistics.log_odds.size() != matches)) {
    return "columns of the motion statistics differ in length";
  }
  int accepted = 0;
  for (size_t i = 0; i < matches; ++i) {
    if (!std::isfinite(statistics.relative_score[i])) return "a relative score is not finite";
    if (!statistics.log_odds.empty() && !std::isfinite(statistics.log_odds[i])) return "log-odds are not finite";
    if (!statistics.accepted[i] && (statistics.score[i] != 0 || statistics.relative_score[i] != 0)) {
      return "a rejected match has a score";
    }
    const int cell = statistics.cell[i];
    if (cell < 0 || cell >= statistics.grid_columns * statistics.grid_rows) return "a match lies in no cell";
    accepted += statistics.accepted[i] != 0;
  }
  return accepted == statistics.accepted_count ? std::string() : "accepted_count is not the number of accepted matches";
}

/// Squared pixels of a match's residual under the model of the result, by the formulas of Hartley and Zisserman (11.9
/// and 4.7) anew. The points are pixels of the ideal pinhole camera.
inline double squaredResidual(const Camera& camera, const RobustResult& result, const cv::Point2f& reference,
                              const cv::Point2f& current) {
  const bool essential = result.model_type == ModelType::kEssential;
  const Eigen::Matrix3d to_model = essential ? Eigen::Matrix3d(camera.K().inverse()) : Eigen::Matrix3d::Identity();
  const double unit = essential ? camera.meanFocalLength() : 1;
  const Eigen::Vector3d r = to_model * Eigen::Vector3d(reference.x, reference.y, 1);
  const Eigen::Vector3d c = to_model * Eigen::Vector3d(current.x, current.y, 1);
  if (result.model_type == ModelType::kHomography) {
    const Eigen::Vector2d forward = (result.model * r).hnormalized() - c.hnormalized();
    const Eigen::Vector2d backward = (result.model.inverse() * c).hnormalized() - r.hnormalized();
    return 0.5 * (forward.squaredNorm() + backward.squaredNorm());
  }
  const Eigen::Vector3d in_current = result.model * r, in_reference = result.model.transpose() * c;
  const double algebraic = c.dot(in_current);
  return unit * unit * algebraic * algebraic /
         (in_current.head<2>().squaredNorm() + in_reference.head<2>().squaredNorm());
}

inline std::string brokenEstimate(const PointPairs& pairs, const Camera& camera, const RobustOptions& options,
                                  const RobustResult& result) {
  if (result.inlier.size() != static_cast<size_t>(pairs.size())) return "the inlier mask has another length";
  int inliers = 0;
  for (const uint8_t inlier : result.inlier) inliers += inlier != 0;
  if (inliers != result.inlier_count) return "inlier_count is not the number of inliers";
  const std::pair<const char*, double> figures[] = {{"median_parallax_px", result.judgement.median_parallax_px},
                                                    {"sigma_px", result.judgement.sigma_px},
                                                    {"noise_exponent", result.judgement.noise_exponent},
                                                    {"camera_misfit", result.judgement.camera_misfit},
                                                    {"rms_error_px", result.rms_error_px}};
  for (const auto& [name, value] : figures) {
    if (!std::isfinite(value) || value < 0) return std::string(name) + " is " + std::to_string(value);
  }
  if (result.effort.hypotheses < 0 || result.effort.models_scored < 0 || result.effort.point_evaluations < 0) {
    return "an effort is negative";
  }
  if (!result.model_found) {
    if (inliers > 0) return "there are inliers without a model";
    if (result.judgement.pose_found) return "there is a pose without a model";
    if (!result.judgement.probability.empty()) return "there are probabilities without a model";
    return std::string();
  }
  if (!result.model.allFinite()) return "the model is not finite";
  if (!result.judgement.probability.empty() && result.judgement.probability.size() != result.inlier.size()) {
    return "the probabilities have another length";
  }
  for (const float p : result.judgement.probability) {
    if (!(p >= 0 && p <= 1)) return "a probability is not between 0 and 1";
  }
  const double threshold = options.inlierThreshold();
  for (size_t i = 0; i < result.inlier.size(); ++i) {
    if (!result.inlier[i]) continue;
    if (!pairs.hasCoordinates(i)) return "a match without coordinates is an inlier";
    const double squared = squaredResidual(camera, result, {pairs.x_reference[i], pairs.y_reference[i]},
                                           {pairs.x_current[i], pairs.y_current[i]});
    if (!(squared <= threshold * threshold * (1 + 1e-6))) {
      std::ostringstream text;
      text << "an inlier is " << std::sqrt(squared) << " px off, beyond the threshold of " << threshold;
      return text.str();
    }
  }
  if (!result.judgement.pose_found) return std::string();
  if (!camera.calibrated()) return "there is a pose without a calibration";
  const double length = result.judgement.pose.t.norm();
  if (result.judgement.translation_observable && std::abs(length - 1) > 1e-6)
    return "a translation is not of unit length";
  return brokenPose(result.judgement.pose);
}

/// The columns of a pair, checked against its frames.
inline std::string brokenResult(const Features& reference, const Features& current, const MatchResult& result) {
  const size_t n = result.matches.size();
  const RobustResult& robust = result.robust;
  if (result.confidence.size() != n || result.pairs.x_reference.size() != n) {
    return "columns of the result differ in length";
  }
  for (const size_t estimated : {result.inlier.size(), robust.inlier.size(), robust.judgement.probability.size(),
                                 robust.judgement.residual.size()}) {
    if (estimated != 0 && estimated != n) return "columns of the estimate differ in length";
  }
  for (size_t i = 0; i < n; ++i) {
    if (!(result.confidence[i] >= 0 && result.confidence[i] <= 1)) return "a confidence is not between 0 and 1";
    if (!(result.probability(i) >= 0 && result.probability(i) <= 1)) return "a probability is not between 0 and 1";
  }
  bool known = true;
  int filtered = 0, inliers = 0;
  result.forEachRaw([&](const Match& match, MatchStage stage, size_t row) {
    known = known && match.reference >= 0 && match.reference < reference.size() && match.current >= 0 &&
            match.current < current.size();
    inliers += stage == MatchStage::kInlier;
    if (stage != MatchStage::kRaw) filtered += result.matches[row].current == match.current;
  });
  if (!known) return "a match names a keypoint that is not there";
  if (filtered != result.size()) return "a filtered match is no raw one";
  if (inliers != result.inliers) return "inliers is not the number of inliers";
  const bool with_pose = result.status == Status::kOk || result.status == Status::kLowParallax;
  if (with_pose && !result.robust.judgement.pose_found) return "the status says a pose and there is none";
  if (with_pose && inliers < kMinimumMatches) return "a pose rests on fewer than eight inliers";
  return with_pose ? brokenPose(result.robust.judgement.pose) : std::string();
}

/// Ids are unique within the image, and only inliers have them.
inline std::string brokenTracks(const TrackTable& tracks, const MatchResult& result) {
  if (tracks.ids().size() != result.matches.size() || tracks.lengths().size() != result.matches.size()) {
    return "columns of the tracks differ in length";
  }
  std::set<uint32_t> seen;
  for (size_t i = 0; i < tracks.ids().size(); ++i) {
    const uint32_t id = tracks.ids()[i];
    if (id == 0) continue;
    if (!result.isInlier(i)) return "a match that is no inlier is followed";
    if (tracks.lengths()[i] < 2) return "a track is shorter than two images";
    if (!seen.insert(id).second) return "two matches of one image have the same id";
  }
  return std::string();
}

inline std::string brokenTriangulation(const Triangulation& points) {
  const size_t n = points.row.size();
  for (const auto* column : {&points.x_reference, &points.y_reference, &points.x_current, &points.y_current,
                             &points.depth_reference, &points.depth_current, &points.parallax}) {
    if (column->size() != n) return "columns of the triangulation differ in length";
  }
  if (points.valid.size() != n) return "columns of the triangulation differ in length";
  for (size_t i = 0; i < n; ++i) {
    if (!points.valid[i]) continue;
    if (!(points.depth_reference[i] > 0) || !(points.depth_current[i] > 0)) return "a valid point is behind a camera";
    if (!points.point(static_cast<int>(i)).allFinite() || !std::isfinite(points.parallax[i])) {
      return "a valid point is not finite";
    }
  }
  return std::string();
}

}  // namespace gms_ransac
