// What RANSAC needs to know of a two-view model. Only the models know what the numbers of a hypothesis mean.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "two_view/kernels/residual_kernels.h"

namespace gms_ransac {

/// X_current = R X_reference + t with |t| = 1.
struct TwoViewPose {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitZ();

  Eigen::Matrix3d essential() const;
  PoseParameters parameters() const;
};

/// One candidate for the motion of a pair, in working coordinates. A model fills the member that is its own.
struct Hypothesis {
  TwoViewPose pose;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
};

constexpr int kMaxSampleSize = 7;
constexpr int kMaxHypotheses = 10;  ///< of one minimal sample

/// The loss of every refinement: matches up to twice the threshold, weights falling from the threshold on
/// (Geman-McClure). Wide enough to pull a model of five noisy points to the optimum of all.
constexpr Loss kRobustLoss = {4, 1};

/// Relative decreases of a cost that are not worth another pass over the matches: for the result, and for a guess that
/// is compared with others (doc/estimator.md).
constexpr float kEnough = 1e-5f;
constexpr float kEnoughToCompare = 1e-3f;

/// A model over the columns of one pair. Residuals are squared and in squared thresholds: 1 is at the threshold.
class TwoViewModel {
 public:
  virtual ~TwoViewModel() = default;

  virtual int sampleSize() const = 0;
  /// Hypotheses of a minimal sample, at most kMaxHypotheses of them, all finite. `sample`: columns.
  virtual int solve(const int* sample, Hypothesis* hypotheses) const = 0;
  /// Cost and inliers among `points`, which may be others than the model's own. False as soon as the cost is known to
  /// exceed `bound`; `evaluations` is raised by the residuals computed.
  virtual bool score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound, HypothesisScore& score,
                     int64_t& evaluations) const = 0;
  /// True when one match is within the threshold, computed in double.
  virtual bool fits(const Hypothesis& hypothesis, int column) const = 0;
  /// The residual of every column, padding included.
  virtual void residuals(const Hypothesis& hypothesis, float* e) const = 0;
  /// Moves the hypothesis to the robust optimum near it; returns the passes over the matches, 0 where the model has no
  /// refinement of its own.
  virtual int refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const = 0;
  /// The matrix of RobustResult::model, in working coordinates.
  virtual Eigen::Matrix3d matrix(const Hypothesis& hypothesis) const = 0;
};

}  // namespace gms_ransac
