#include "two_view/homography_model.h"

#include <Eigen/LU>

#include "two_view/levenberg_marquardt.h"
#include "two_view/minimal_sample.h"
#include "two_view/pose_model.h"
#include "two_view/solvers/homography_4pt.h"

namespace gms_ransac {

int HomographyModel::solve(const int* sample, Hypothesis* hypotheses) const {
  const MinimalSample<4> points(points_, sample);
  Eigen::Matrix3d matrix;
  if (keepFinite(&matrix, solveHomography4(points.reference, points.current, &matrix), hypotheses) == 0) return 0;
  if (!oriented_) return 1;
  int positive = 0;
  for (const auto& x : points.reference) positive += matrix.row(2).dot(Eigen::RowVector3d(x[0], x[1], 1)) > 0;
  return positive == 0 || positive == sampleSize() ? 1 : 0;
}

bool HomographyModel::score(const PointColumnsView& points, const Hypothesis& hypothesis, float bound,
                            HypothesisScore& score, int64_t& evaluations) const {
  float h[9], g[9];
  toFloat(hypothesis.matrix, h);
  toFloat(hypothesis.matrix.inverse(), g);
  kernels_.scoreHomography(points, h, g, bound, score);
  evaluations += score.evaluated;
  return score.cost < bound;  // false also for the NaN of a singular matrix
}

bool HomographyModel::fits(const Hypothesis& hypothesis, int i) const {
  return points_.weight[i] * transferSquared(hypothesis.matrix, hypothesis.matrix.inverse(), points_.x1[i],
                                             points_.y1[i], points_.x2[i], points_.y2[i]) <
         1;
}

void HomographyModel::residuals(const Hypothesis& hypothesis, float* e) const {
  float h[9];
  toFloat(hypothesis.matrix, h);
  kernels_.transferResiduals(points_, h, e);
}

int HomographyModel::refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const {
  Eigen::Matrix3d& H = hypothesis.matrix;
  // The scale is fixed by the entry of largest size; the other eight are free.
  int fixed = 0;
  for (int k = 1; k < 9; ++k) {
    if (std::abs(H(k / 3, k % 3)) > std::abs(H(fixed / 3, fixed % 3))) fixed = k;
  }
  const auto entry = [fixed](int parameter) { return parameter < fixed ? parameter : parameter + 1; };
  const auto linearize = [&](const Eigen::Matrix3d& at, NormalEquations<8>& result) {
    float m[9], D[8][9] = {};
    toFloat(at, m);
    for (int k = 0; k < 8; ++k) D[k][entry(k)] = 1;
    kernels_.linearizeHomography(points_, m, D, loss, result);
  };
  const auto cost = [&](const Eigen::Matrix3d& at) {
    float m[9];
    toFloat(at, m);
    return kernels_.transferCost(points_, m, loss);
  };
  const auto moved = [&entry](const Eigen::Matrix3d& from, const double(&step)[8]) {
    Eigen::Matrix3d to = from;
    for (int k = 0; k < 8; ++k) to(entry(k) / 3, entry(k) % 3) += step[k];
    return to;
  };
  const int passes = minimizeRobustCost<8>(iterations, kEnough, H, linearize, cost, moved);
  H /= H.norm();
  return passes;
}

}  // namespace gms_ransac
