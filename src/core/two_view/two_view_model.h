// The room two_view has the models of two views: hypotheses of a sample, residuals, refinement. A new model is a
// TwoViewModel; the loops over all matches are kernels, equal bit by bit on every instruction set.
//
// Interface of two-view models for RANSAC. Only the models know the meaning of a hypothesis.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "two_view/two_view_pose.h"

#include "two_view/kernels/residual_kernels.h"

namespace gms_ransac {

/// One candidate for the motion of a pair, in working coordinates. A model fills the member that is its own.
struct Hypothesis {
  TwoViewPose pose;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
};

constexpr int kMaxSampleSize = 7;
constexpr int kMaxHypotheses = 10;  ///< of one minimal sample

/// Loss of every refinement (Geman-McClure), wide enough to pull a model of five noisy points to the optimum.
constexpr Loss kRobustLoss = {4, 1};

/// Relative decreases of a cost below which refinement stops: of the result, and of a guess to compare with others.
constexpr float kEnough = 1e-5f;
constexpr float kEnoughToCompare = 1e-3f;

/// Steps of the refinement of a result, which mostly converges after three to five.
constexpr int kFinalIterations = 10;

/// A model over the points of one pair. Residuals are squared and in squared thresholds: 1 is at the threshold.
class TwoViewModel {
 public:
  TwoViewModel(const ResidualKernels& kernels, const PointColumnsView& points) : kernels_(kernels), points_(points) {}
  virtual ~TwoViewModel() = default;

  virtual int sampleSize() const = 0;
  /// Hypotheses of a minimal sample, at most kMaxHypotheses of them, all finite. `sample`: slots.
  virtual int solve(const int* sample, Hypothesis* hypotheses) const = 0;
  /// Cost and inliers among `points`. False as soon as the cost exceeds `bound`.
  virtual bool score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound,
                     HypothesisScore& score) const = 0;
  /// True when the match of one slot is within the threshold, computed in double.
  virtual bool fits(const Hypothesis& hypothesis, int slot) const = 0;
  /// Residual of every slot, padding included.
  virtual void residuals(const Hypothesis& hypothesis, std::vector<float>& e) const = 0;
  /// Moves the hypothesis to the robust optimum near it.
  virtual void refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const = 0;
  virtual Eigen::Matrix3d matrix(const Hypothesis& hypothesis) const = 0;

 protected:
  const ResidualKernels& kernels_;
  PointColumnsView points_;
};

// In double, which the final inlier masks are computed in.
/// Squared Sampson distance to x_current^T M x_reference = 0 (Hartley & Zisserman, eq. 11.9). NaN at both epipoles.
inline double sampsonSquared(const Eigen::Matrix3d& M, double x_reference, double y_reference, double x_current,
                             double y_current) {
  const Eigen::Vector3d reference(x_reference, y_reference, 1), current(x_current, y_current, 1);
  const Eigen::Vector3d line_current = M * reference, line_reference = M.transpose() * current;
  const double algebraic = current.dot(line_current);
  return algebraic * algebraic / (line_current.head<2>().squaredNorm() + line_reference.head<2>().squaredNorm());
}

/// Mean of the two squared transfer distances of a homography (Hartley & Zisserman, eq. 4.7, halved).
inline double transferSquared(const Eigen::Matrix3d& H, const Eigen::Matrix3d& H_inverse, double x_reference,
                              double y_reference, double x_current, double y_current) {
  const Eigen::Vector3d forward = H * Eigen::Vector3d(x_reference, y_reference, 1);
  const Eigen::Vector3d backward = H_inverse * Eigen::Vector3d(x_current, y_current, 1);
  const Eigen::Vector2d in_current = forward.hnormalized() - Eigen::Vector2d(x_current, y_current);
  const Eigen::Vector2d in_reference = backward.hnormalized() - Eigen::Vector2d(x_reference, y_reference);
  return 0.5 * (in_current.squaredNorm() + in_reference.squaredNorm());
}

template <int kSize>
struct MinimalSample {
  double reference[kSize][2], current[kSize][2];

  MinimalSample(const PointColumnsView& points, const int* sample) {
    for (int k = 0; k < kSize; ++k) {
      const int slot = sample[k];
      reference[k][0] = points.x1[slot];
      reference[k][1] = points.y1[slot];
      current[k][0] = points.x2[slot];
      current[k][1] = points.y2[slot];
    }
  }
};

/// Copies the matrices that are finite; returns how many.
inline int keepFinite(const Eigen::Matrix3d* matrices, int count, Hypothesis* hypotheses) {
  int finite = 0;
  for (int k = 0; k < count; ++k) {
    if (matrices[k].allFinite()) hypotheses[finite++].matrix = matrices[k];
  }
  return finite;
}

/// Row-major copy in float.
inline void toFloat(const Eigen::Matrix3d& m, float (&out)[9]) {
  for (int i = 0; i < 9; ++i) out[i] = static_cast<float>(m(i / 3, i % 3));
}

struct FloatMatrix {
  float entry[9];
  explicit FloatMatrix(const Eigen::Matrix3d& m) { toFloat(m, entry); }
};

/// A model judged by the epipolar lines of its matrix.
class EpipolarModel : public TwoViewModel {
 public:
  using TwoViewModel::TwoViewModel;

  bool score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound,
             HypothesisScore& score) const override {
    kernels_.scoreEpipolar(points, FloatMatrix(matrix(hypothesis)).entry, bound, score);
    points.countResiduals(score.evaluated);
    return score.cost < bound;
  }
  bool fits(const Hypothesis& hypothesis, int slot) const override {
    points_.countResiduals(1);
    return points_.weight[slot] * sampsonSquared(matrix(hypothesis), points_.x1[slot], points_.y1[slot],
                                                 points_.x2[slot], points_.y2[slot]) <
           1;
  }
  void residuals(const Hypothesis& hypothesis, std::vector<float>& e) const override {
    e.resize(static_cast<size_t>(points_.size));
    kernels_.epipolarResiduals(points_, FloatMatrix(matrix(hypothesis)).entry, e.data());
    points_.countPasses(1);
  }
  Eigen::Matrix3d matrix(const Hypothesis& hypothesis) const override { return hypothesis.matrix; }
};

}  // namespace gms_ransac
