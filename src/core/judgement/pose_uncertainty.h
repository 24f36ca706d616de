// How well the matches determine a pose: a covariance that holds for noise that neighbours share and for what the
// camera model leaves out. Derived in doc/uncertainty.md.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/robust_estimator.h"
#include "judgement/match_noise.h"
#include "judgement/pose_break.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

/// First-order uncertainty of a pose in the parameters of PoseModel::linearize: rotation vector w of R <- exp(w) R,
/// then steps of t along PoseModel::tangent.
struct PoseSpread {
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Identity();
  /// What it would be if the camera model were beyond doubt.
  Eigen::Matrix<double, 5, 5> of_matches = Eigen::Matrix<double, 5, 5>::Identity();
  /// What it seems at first, with noise counted as parallax and no heed of leverage: what a preferred rotation is
  /// weighed against, which a wider one would follow further than errors do.
  Eigen::Matrix<double, 5, 5> sandwich = Eigen::Matrix<double, 5, 5>::Identity();
  /// How far the residuals contradict the camera model, by the parameter that they contradict most: 1 is where chance
  /// alone would bring one pair in a hundred.
  double contradiction = 0;
  CameraParameter contradicted = CameraParameter::kFocalLength;
  /// The part of the view whose matches contradict the rest most.
  PoseBreak pose_break;

  /// Standard deviation of the direction of translation along its widest axis, radians.
  double directionSigma() const;
};

class PoseUncertainty {
 public:
  /// `noise`: measured at `pose`; `cells`: of each column; `calibration_sigma`: RobustOptions::calibration_sigma.
  PoseSpread measure(const PointColumnsView& points, const TwoViewPose& pose, const MatchNoise& noise,
                     const std::vector<int32_t>& cells, double calibration_sigma);

 private:
  static constexpr int kPose = 5, kUnmodelledCount = 10, kAll = kPose + kUnmodelledCount;
  using Row = Eigen::Matrix<double, kAll, 1>;
  using Information = Eigen::Matrix<double, kAll, kAll>;
  using Pose = Eigen::Matrix<double, kPose, 1>;
  using Square = Eigen::Matrix<double, kPose, kPose>;

  /// Gathers the matches that take part.
  void collect(const PointColumnsView& points, const MatchNoise& noise, float cut);
  /// Fills J_, turns_ and pulls_; returns the mean second derivative of the loss.
  double differentiate(const TwoViewPose& pose, const Loss& loss);
  /// Fills gradients_; the matches of a cell are a cluster. Returns their number.
  int sumByCell(const std::vector<int32_t>& cells);
  /// Fills the sums over the matches; returns how many took part.
  int sumUp(const PointColumnsView& points, const TwoViewPose& pose, const MatchNoise& noise,
            const std::vector<int32_t>& cells);
  /// Test of the camera model by the scores of its parameters.
  void testModel(const Square& inverse, PoseSpread& spread) const;
  /// Sums of the used matches for the test of breaks.
  template <int N>
  void sumUpBlocks(const std::vector<int32_t>& cells, BlockSums<N>& blocks) const;
  PoseBreak findBreak(const std::vector<int32_t>& cells, double variance);
  /// That of the matches on the pose, less what noise of the points feigns of the direction.
  Square information(double variance) const;
  /// Scatter of the gradients of the cells, of one with much leverage that at the pose without it. `inverse`: of the
  /// curvature.
  Square scatterWithoutLeverage(const std::vector<int32_t>& cells, const Square& inverse) const;
  /// What a sandwich of few cells must be scaled by to reach what leaving out parts of the view changes; `step`: what
  /// the pose lacks to the optimum.
  Pose widening(const Square& sandwich, const Pose& step) const;
  /// The inverse of the information with the parameters beside the pose unknown up to `sigma`.
  Information extendedInverse(const Eigen::Matrix<double, kUnmodelledCount, 1>& sigma, double variance) const;
  /// Covariance of the pose when the parameters beside it are unknown up to `sigma`, and the step that freeing them
  /// would make.
  Eigen::Matrix<double, kPose, kPose> extendedCovariance(const Eigen::Matrix<double, kUnmodelledCount, 1>& sigma,
                                                         double variance) const;

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
Eigen::Matrix<double, 6, 6> relativeCovariance(const TwoViewPose& pose, const Eigen::Matrix<double, 5, 5>& covariance);

}  // namespace gms_ransac
