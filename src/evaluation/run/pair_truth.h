// Truth of an image pair: distances of matches from their true epipolar lines or true positions, and labels of matches.
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "datasets/dataset.h"
#include "gms_ransac/camera.h"
#include "gms_ransac/match_filter.h"
#include "run/truth_noise.h"

namespace gms_ransac {

/// A match is correct when it lies this close to the truth, pixels.
constexpr double kCorrectWithin = 3.0;

constexpr double kDegrees = 180 / M_PI;  ///< in a radian

/// Errors of an estimated relative pose, degrees; at first those of a pair without a pose.
struct PoseError {
  double rotation = 180;   ///< angle of R_true^T R
  double direction = 180;  ///< angle between the translations; 90 when the estimate is zero
};
/// Both poses are current_in_reference (X_reference = R X_current + t).
PoseError poseError(const Eigen::Isometry3d& truth, const Eigen::Matrix3d& R, const Eigen::Vector3d& t);

class PairTruth {
 public:
  /// Reads depth or disparity when the set has it. `camera` may be uncalibrated: poses then say nothing of pixels.
  PairTruth(const Dataset& dataset, const DatasetPair& pair, const Camera& camera, const TruthNoise& noise = {});

  const std::optional<Eigen::Isometry3d>& currentInReference() const { return current_in_reference_; }
  bool hasEpipolar() const { return essential_ || pair_.fundamental; }
  /// Larger of the two distances to the epipolar lines, pixels of the ideal pinhole camera (of the image for a given
  /// fundamental matrix).
  double epipolarDistance(const cv::Point2f& reference, const cv::Point2f& current) const;

  bool hasTransfer() const { return pair_.homography || !disparity_.empty() || !depth_.empty(); }
  /// Distance of the current point from where homography, disparity or depth sends the reference point; absent where
  /// the truth has a hole. The least over the disparities or depths within `reach` pixels of the reference point: a
  /// corner at the edge of a near surface belongs to it, on whichever side of the edge it was found.
  std::optional<double> transferDistance(const cv::Point2f& reference, const cv::Point2f& current, int reach = 0) const;

  const TruthNoise& noise() const { return noise_; }
  /// Covariances of the true pose; zero without one.
  const PairNoise& pairNoise() const { return pair_noise_; }
  /// Whether a match is right: within kCorrectWithin of its true place (homography, disparity, depth) or, where that is
  /// not known, of its epipolar line. Two standard deviations of the true pose widen the limit; absent where it exceeds
  /// 10 pixels, or where nothing is known.
  std::optional<bool> label(const cv::Point2f& reference, const cv::Point2f& current) const;

 private:
  double parallax(const cv::Point2f& reference, const cv::Point2f& current) const;

  DatasetPair pair_;
  Camera camera_;
  Eigen::Matrix3d K_inverse_;
  std::optional<Eigen::Isometry3d> current_in_reference_;
  std::optional<Eigen::Matrix3d> essential_;  ///< reference^T E current = 0 with a unit translation
  cv::Mat disparity_, depth_;                 ///< CV_32FC1, of the reference; empty: unknown
  TruthNoise noise_;
  PairNoise pair_noise_;
  double rotation_px_ = 0, translation_sigma_ = 0;  ///< pair_noise_ along its worst axes, pixels and metres
};

}  // namespace gms_ransac
