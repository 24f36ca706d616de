// The essential matrix as a pose: hypotheses from five points, score with cheirality, refinement on its five degrees
// of freedom.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "robust/fast/levenberg_marquardt.h"
#include "robust/fast/residual_kernels.h"

namespace gms_ransac {

/// X_current = R X_reference + t with |t| = 1.
struct TwoViewPose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitZ();

  Eigen::Matrix3d essential() const;
  PoseParameters parameters() const;
};

/// [v]x, and the rotation by |v| about v.
Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v);
Eigen::Matrix3d rotationFromVector(const Eigen::Vector3d& v);
/// Replaces R by the nearest rotation, to rounding; false, with R undefined, when it is far from any.
bool makeRotation(Eigen::Matrix3d& R);
/// Row-major copy in float.
void toFloat(const Eigen::Matrix3d& m, float (&out)[9]);

/// The prior of the estimator; measured in doc/estimator.md.
constexpr ParallaxPrior kParallaxPrior = {0.03f, 0.05f};

class PoseModel {
 public:
  static constexpr int kSampleSize = 5;
  static constexpr int kMaxHypotheses = 10;
  using Hypothesis = TwoViewPose;

  PoseModel(const ResidualKernels& kernels, const PointColumnsView& points, const ParallaxPrior& prior = {})
      : kernels_(kernels), points_(points), prior_(prior) {}

  /// Poses of a sample (column positions) whose points lie in front of both cameras, or so far that it cannot be told.
  int generate(const int* sample, Hypothesis* hypotheses) const;
  /// False as soon as the cost is known to exceed `bound`.
  bool score(const Hypothesis& pose, float bound, Score& score, int64_t& evaluations) const;
  /// The pose or the one with the opposite t, which the Sampson distance cannot tell from it: the one of lower cost.
  Hypothesis withBetterSign(const Hypothesis& pose, float& cost, int64_t& evaluations) const;
  /// The Sampson distance of every match.
  void residuals(const Hypothesis& pose, float* e) const;
  /// That, or more for a match behind a camera: what score() sums up, without the prior.
  void residualsInFront(const Hypothesis& pose, float* e) const;
  /// Levenberg-Marquardt; returns passes over the matches.
  int refine(const Loss& loss, int iterations, Hypothesis& pose, float enough = kEnoughToCompare) const;
  /// Normal equations at a pose, with the prior; parameters: rotation vector w of R <- exp(w) R, then steps of t along
  /// tangent().
  void linearize(const Hypothesis& pose, const Loss& loss, NormalEquations<5>& equations) const;

  /// The same for a motion without translation, whose residual is the transfer distance in the current image.
  int refineRotation(const Loss& loss, int iterations, Eigen::Matrix3d& R) const;
  void linearizeRotation(const Eigen::Matrix3d& R, const Loss& loss, NormalEquations<3>& equations) const;
  void rotationResiduals(const Eigen::Matrix3d& R, float* e) const;

  /// The two unit vectors that span the plane of steps of t.
  static void tangent(const Eigen::Vector3d& t, Eigen::Vector3d (&basis)[2]);

 private:
  const ResidualKernels& kernels_;
  PointColumnsView points_;
  ParallaxPrior prior_;
};

}  // namespace gms_ransac
