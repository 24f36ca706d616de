// The essential matrix as a pose: hypotheses from five points, score with cheirality, refinement on its five degrees
// of freedom. And plainly, as the textbook has it.
#pragma once

#include <Eigen/Core>

#include "two_view/two_view_model.h"

namespace gms_ransac {

/// [v]x, and the rotation by |v| about v.
Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v);
Eigen::Matrix3d rotationFromVector(const Eigen::Vector3d& v);
/// The inverse: axis times angle.
Eigen::Vector3d rotationVector(const Eigen::Matrix3d& R);
/// Maps a perturbation at one point of a rigid body to another one, `lever` away, in axes rotated by R: [R, -R
/// [lever]x; 0, R]. Translation first, as in RelativePose::covariance.
Eigen::Matrix<double, 6, 6> leverTransform(const Eigen::Matrix3d& R, const Eigen::Vector3d& lever);
/// The pose of c in a, of b in a and c in b with independent errors.
RelativePose chained(const RelativePose& b_in_a, const RelativePose& c_in_b);
/// Replaces R by the nearest rotation, to rounding; false, with R undefined, when it is far from any.
bool makeRotation(Eigen::Matrix3d& R);

/// The prior of the estimator; measured in doc/measured/constants.md.
constexpr ParallaxPrior kParallaxPrior = {0.03f, 0.05f};

class PoseModel : public EpipolarModel {
 public:
  PoseModel(const ResidualKernels& kernels, const PointColumnsView& points, const ParallaxPrior& prior = {})
      : EpipolarModel(kernels, points), prior_(prior) {}

  const PointColumnsView& points() const { return points_; }
  /// The same model of the first slots alone.
  PoseModel first(int count) const { return {kernels_, firstSlots(points_, count), prior_}; }

  int sampleSize() const override { return 5; }
  /// Poses of a sample whose points lie in front of both cameras, or so far that it cannot be told.
  int solve(const int* sample, Hypothesis* hypotheses) const override;
  bool score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound,
             HypothesisScore& score) const override {
    return this->score(points, hypothesis.pose, bound, score);
  }
  using EpipolarModel::residuals;
  void refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const override {
    refine(loss, iterations, hypothesis.pose);
  }
  Eigen::Matrix3d matrix(const Hypothesis& hypothesis) const override { return hypothesis.pose.essential(); }

  bool score(const PointColumnsView& points, const TwoViewPose& pose, float bound, HypothesisScore& score) const;
  /// The pose or the one with the opposite t, which the Sampson distance cannot tell from it: the one of lower cost.
  TwoViewPose withBetterSign(const TwoViewPose& pose, float& cost) const;
  /// The Sampson distance of every slot.
  void residuals(const TwoViewPose& pose, std::vector<float>& e) const { residuals(Hypothesis{pose}, e); }
  /// That, or more for a match behind a camera: what score() sums up, without the prior.
  void residualsInFront(const TwoViewPose& pose, std::vector<float>& e) const;
  /// Levenberg-Marquardt.
  void refine(const Loss& loss, int iterations, TwoViewPose& pose, float enough = kEnoughToCompare) const;
  /// Normal equations at a pose, with the prior; parameters: rotation vector w of R <- exp(w) R, then steps of t along
  /// tangent().
  void linearize(const TwoViewPose& pose, const Loss& loss, NormalEquations<5>& equations) const;

  /// ResidualKernels::differentiatePose at a pose.
  DerivativeSums differentiate(const TwoViewPose& pose, const Loss& loss, float* columns) const;

  /// The same for a motion without translation, whose residual is the transfer distance in the current image.
  void refineRotation(const Loss& loss, int iterations, Eigen::Matrix3d& R) const;
  void linearizeRotation(const Eigen::Matrix3d& R, const Loss& loss, NormalEquations<3>& equations) const;
  void rotationResiduals(const Eigen::Matrix3d& R, std::vector<float>& e) const;

  static void tangent(const Eigen::Vector3d& t, Eigen::Vector3d (&basis)[2]);
  static void tangent(const Eigen::Vector3d& t, float (&steps)[2][3]);

 private:
  ParallaxPrior prior_;
};

/// The essential matrix of the textbook: scored by its epipolar lines alone, refined as a pose afterwards.
class EssentialModel : public EpipolarModel {
 public:
  using EpipolarModel::EpipolarModel;

  int sampleSize() const override { return 5; }
  int solve(const int* sample, Hypothesis* hypotheses) const override;
  void refine(const Loss& /*loss*/, int /*iterations*/, Hypothesis& /*hypothesis*/) const override {}
};

}  // namespace gms_ransac
