// How well the matches determine a pose: a covariance that holds for noise that neighbours share and for what the
// camera model leaves out. Derived in doc/uncertainty.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/robust_estimator.h"
#include "judgement/camera_doubt.h"
#include "judgement/match_noise.h"
#include "judgement/pose_break.h"
#include "judgement/residual_derivatives.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

constexpr int kPoseParameters = ResidualDerivatives::kOfPose;
using PoseSquare = Eigen::Matrix<double, kPoseParameters, kPoseParameters>;

/// First-order uncertainty of a pose in the parameters of PoseModel::linearize: rotation vector w of R <- exp(w) R,
/// then steps of t along PoseModel::tangent.
struct PoseSpread {
  PoseSquare covariance = PoseSquare::Identity();
  /// What it would be if the camera model were beyond doubt.
  PoseSquare of_matches = PoseSquare::Identity();
  /// What it would be if nothing were known of the camera but that it is off by no more than those in use are.
  PoseSquare of_any_camera = PoseSquare::Identity();
  /// What it seems at first, with noise counted as parallax and no heed of leverage: what a preferred rotation is
  /// weighed against, which a wider one would follow further than errors do.
  PoseSquare sandwich = PoseSquare::Identity();
  /// How far the residuals contradict the camera model, by the parameter that they contradict most: 1 is where chance
  /// alone would bring one pair in a hundred.
  double contradiction = 0;
  CameraParameter contradicted = CameraParameter::kFocalLength;
  CameraErrors camera_errors;
  /// The part of the view whose matches contradict the rest most.
  PoseBreak pose_break;
};

/// Standard deviation of the direction of translation along its widest axis, radians.
double directionSigma(const PoseSquare& covariance);

class PoseUncertainty {
 public:
  /// `noise`: measured at `pose`; `cells`: of each column; `calibration_sigma`: RobustOptions::calibration_sigma.
  PoseSpread measure(const PointColumnsView& points, const TwoViewPose& pose, const MatchNoise& noise,
                     const std::vector<int32_t>& cells, double calibration_sigma);

 private:
  static constexpr int kPose = kPoseParameters, kUnmodelledCount = Unmodelled::kCount, kAll = kPose + kUnmodelledCount;
  static constexpr int kCells = kSpreadGridSide * kSpreadGridSide;
  static_assert(kCells % kLanesAtOnce == 0, "whole steps of lanes");
  using Row = Eigen::Matrix<double, kAll, 1>;
  using Information = Eigen::Matrix<double, kAll, kAll>;
  using Pose = Eigen::Matrix<double, kPose, 1>;

  /// Gathers the matches that take part.
  void collect(const PointColumnsView& points, const MatchNoise& noise, float cut);
  /// Fills J_, turns_ and pulls_; returns the mean second derivative of the loss.
  double differentiate(const TwoViewPose& pose, const Loss& loss);
  /// Fills gradients_; the matches of a cell are a cluster. Returns their number.
  int sumByCell(const std::vector<int32_t>& cells);
  /// Fills the sums over the matches; returns how many took part.
  int sumUp(const PointColumnsView& points, const TwoViewPose& pose, const MatchNoise& noise,
            const std::vector<int32_t>& cells);
  /// `inverse`: of the pose's information.
  CameraScores cameraScores(const PoseSquare& inverse) const;
  /// Sums of the used matches for the test of breaks.
  template <int N>
  void sumUpBlocks(const std::vector<int32_t>& cells, BlockSums<N>& blocks) const;
  /// `extended_inverse`: of extendedInverse.
  PoseBreak findBreak(const std::vector<int32_t>& cells, const Information& extended_inverse);
  /// That of the matches on the pose, less what noise of the points feigns of the direction.
  PoseSquare information(double variance) const;
  /// Of the cell that a used match lies in.
  size_t clusterOf(const std::vector<int32_t>& cells, int used) const;
  /// Of each cluster, its part of the trace of the hat matrix. `inverse`: of the curvature.
  std::array<float, kCells> leverages(const std::vector<int32_t>& cells, const PoseSquare& inverse) const;
  /// What the matches of one cluster add to the curvature.
  PoseSquare curvatureOf(size_t cluster, const std::vector<int32_t>& cells) const;
  /// Scatter of the gradients of the cells, of one with much leverage that at the pose without it. `inverse`: of the
  /// curvature.
  PoseSquare scatterWithoutLeverage(const std::vector<int32_t>& cells, const PoseSquare& inverse) const;
  /// What a sandwich of few cells must be scaled by to reach what leaving out parts of the view changes; `step`: what
  /// the pose lacks to the optimum.
  Pose widening(const PoseSquare& sandwich, const Pose& step) const;
  /// The inverse of the information with the parameters beside the pose unknown up to unmodelledSigma().
  Information extendedInverse(double variance) const;
  /// Covariance of the pose when they are, and the step that freeing them would make.
  PoseSquare extendedCovariance(const Information& extended_inverse, double variance) const;

  Information curvature_, scatter_;
  Row gradient_;
  double bend_ = 1;  ///< mean second derivative of the loss
  int clusters_ = 0;
  BlockSums<kPose> pose_blocks_;
  BlockSums<kAll> all_blocks_;
  std::vector<PoseBreak> suspects_;
  std::vector<int> used_;     ///< columns that take part
  PointColumns columns_;      ///< these alone
  std::vector<float> J_;      ///< derivatives of each match's residual, one parameter after the other
  std::vector<float> turns_;  ///< of each match's epipolar line by either step of t, one step after the other
  std::vector<float> pulls_;  ///< half the derivative of each match's loss by its residual
  std::vector<double>
      gradients_;  ///< of the loss, summed over the matches of each cluster, one parameter after the other
  std::vector<int> cluster_of_;  ///< of each cell; -1: it has no match
};

/// The covariance in the project's convention (see RelativePose).
Eigen::Matrix<double, 6, 6> relativeCovariance(const TwoViewPose& pose, const PoseSquare& covariance);

}  // namespace gms_ransac
