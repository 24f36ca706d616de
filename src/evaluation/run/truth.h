// Truth of an image pair and its noise: errors of a pose, distances of matches from their true epipolar lines or true
// positions, and labels of matches.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "datasets/dataset.h"
#include "gms_ransac/camera.h"

namespace gms_ransac {

/// Noise of a data set's true motion from image to image, standard deviations for each axis. doc/measured/trust.md has
/// the figures of each kind of set.
struct TruthNoise {
  double rotation = 0;     ///< radians
  double translation = 0;  ///< metres
  double clock = 0;        ///< seconds; constant offset of the images' stamps against those of the truth
  double alignment = 0;    ///< radians; constant rotation of the axes of the truth against those of the camera

  /// True for rendered scenes.
  bool exact() const { return rotation == 0 && translation == 0 && clock == 0 && alignment == 0; }
};

/// The noise for a set, by its name (kitti, tum, freiburg, 7scenes, euroc, rendered), else by its layout.
TruthNoise defaultTruthNoise(const std::string& path);

/// Change of the true motion of a pair by a clock offset of one standard deviation.
struct ClockStep {
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rotation vector, radians
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< metres
};

/// Zero where the truth is not known around both frames.
ClockStep clockStep(const Dataset& dataset, const DatasetPair& pair, double clock);

/// Covariances of the true motion of one pair (current_in_reference), in the reference frame.
struct PairNoise {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();     ///< of the rotation vector, radians squared
  Eigen::Matrix3d translation = Eigen::Matrix3d::Zero();  ///< metres squared

  PairNoise() = default;
  PairNoise(const TruthNoise& noise, const ClockStep& step, const Eigen::Isometry3d& truth);
};

/// Returns true if the baseline (metres) is ten standard deviations of the truth or more: its direction is then known
/// to six degrees.
bool hasMoved(double baseline, const TruthNoise& noise);

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
  /// True for a match within kCorrectWithin of its true place (homography, disparity, depth) or, where that is not
  /// known, of its epipolar line. Two standard deviations of the true pose widen the limit; absent where it exceeds 10
  /// pixels, or where nothing is known.
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
