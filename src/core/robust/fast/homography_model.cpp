#include "robust/fast/homography_model.h"

#include <Eigen/LU>

#include "robust/fast/levenberg_marquardt.h"
#include "robust/fast/pose_model.h"
#include "robust/solvers/homography_4pt.h"

namespace gms_ransac {

int HomographyModel::generate(const int* sample, Hypothesis* hypotheses) const {
  double x1[4][2], x2[4][2];
  for (int k = 0; k < 4; ++k) {
    const int i = sample[k];
    x1[k][0] = points_.x1[i];
    x1[k][1] = points_.y1[i];
    x2[k][0] = points_.x2[i];
    x2[k][1] = points_.y2[i];
  }
  if (solveHomography4(x1, x2, hypotheses) == 0) return 0;
  int positive = 0;
  for (const auto& x : x1) positive += hypotheses[0].row(2).dot(Eigen::RowVector3d(x[0], x[1], 1)) > 0;
  return positive == 0 || positive == kSampleSize ? 1 : 0;
}

bool HomographyModel::score(const Hypothesis& H, float bound, Score& score, int64_t& evaluations) const {
  float h[9], g[9];
  toFloat(H, h);
  toFloat(H.inverse(), g);
  kernels_.scoreHomography(points_, h, g, bound, score);
  evaluations += score.evaluated;
  return score.cost < bound;  // false also for the NaN of a singular matrix
}

void HomographyModel::residuals(const Hypothesis& H, float* e) const {
  float h[9];
  toFloat(H, h);
  kernels_.transferResiduals(points_, h, e);
}

int HomographyModel::refine(const Loss& loss, int iterations, Hypothesis& H) const {
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
  const auto moved = [&entry](const Eigen::Matrix3d& from, const double(&step)[8]) {
    Eigen::Matrix3d to = from;
    for (int k = 0; k < 8; ++k) to(entry(k) / 3, entry(k) % 3) += step[k];
    return to;
  };
  NormalEquations<8> equations;
  const int passes = minimizeRobustCost<8>(iterations, kEnough, H, equations, linearize, moved);
  H /= H.norm();
  return passes;
}

}  // namespace gms_ransac
