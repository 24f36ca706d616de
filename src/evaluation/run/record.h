// One answer of `evaluate run`: what was asked of a pair, what came out, and how it compares with the truth.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/match_filter.h"
#include "run/metrics.h"
#include "run/pair_truth.h"

namespace gms_ransac {

/// What the run asked for.
struct RecordContext {
  std::string method;
  ModelType model = ModelType::kEssential;
  std::string reference, current;  ///< names of the frames
  int features = 0, gap = 0, repeat = 0;
  uint64_t seed = 0;
};

/// Scores of one pair; what the truth does not cover is absent.
struct PairScore {
  bool has_true_pose = false;
  std::optional<PoseError> pose;  ///< absent when no pose was found
  std::optional<MatchCounts> epipolar, transfer;
};

struct Record {
  RecordContext context;
  std::string status;
  int keypoints_reference = 0, keypoints_current = 0, matches_raw = 0, matches_gms = 0, inliers = 0;
  int hypotheses = 0, models_scored = 0;
  int64_t point_evaluations = 0;
  bool has_pose = false;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();                               ///< current_in_reference
  Eigen::Vector3d t = Eigen::Vector3d::Zero();                                   ///< unit length
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< RelativePose's
  double median_parallax_px = 0, rms_error_px = 0, sigma_px = 0;
  StageTimes times;
  /// Of each inlier: u_reference v_reference u_current v_current confidence, and the probability that it is right.
  std::vector<std::array<float, 6>> correspondences;
  PairScore score;
};

Record makeRecord(const RecordContext& context, const Features& reference, const Features& current,
                  const MatchResult& result, const PairTruth& truth);

/// One line of JSON without the line break. Pixels are those of the received image; times are milliseconds.
std::string toJsonLine(const Record& record);

}  // namespace gms_ransac
