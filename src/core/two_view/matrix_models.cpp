#include "two_view/matrix_models.h"

#include <algorithm>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "two_view/levenberg_marquardt.h"
#include "two_view/pose_model.h"
#include "two_view/solvers/minimal_solvers.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

namespace {

struct RankTwo {
  Eigen::Matrix3d U, V;
  double s;

  Eigen::Matrix3d matrix() const { return U.col(0) * V.col(0).transpose() + s * U.col(1) * V.col(1).transpose(); }
};

/// For all sample points e2 x x2 must be the same-signed multiple of F x1, with e2 the epipole in the current image.
bool oriented(const Eigen::Matrix3d& F, const PointColumnsView& points, const int* sample, int size) {
  const Eigen::Vector3d products[3] = {F.col(0).cross(F.col(1)), F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0))};
  int best = 0;
  for (int k = 1; k < 3; ++k) {
    if (products[k].squaredNorm() > products[best].squaredNorm()) best = k;
  }
  const Eigen::Vector3d& epipole = products[best];
  int positive = 0;
  for (int k = 0; k < size; ++k) {
    const int slot = sample[k];
    const Eigen::Vector3d line = F * Eigen::Vector3d(points.x1[slot], points.y1[slot], 1);
    positive += line.dot(epipole.cross(Eigen::Vector3d(points.x2[slot], points.y2[slot], 1))) > 0;
  }
  return positive == 0 || positive == size;
}

}  // namespace

int FundamentalModel::solve(const int* sample, Hypothesis* hypotheses) const {
  const MinimalSample<7> points(points_, sample);
  Eigen::Matrix3d matrices[kMaxHypotheses];
  int count = keepFinite(matrices, solveFundamental7(points.reference, points.current, matrices), hypotheses);
  if (!oriented_) return count;
  const auto end = std::remove_if(hypotheses, hypotheses + count, [&](const Hypothesis& hypothesis) {
    return !oriented(hypothesis.matrix, points_, sample, sampleSize());
  });
  return static_cast<int>(end - hypotheses);
}

void FundamentalModel::refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const {
  Eigen::Matrix3d& F = hypothesis.matrix;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[0] > 0)) return;
  RankTwo state{svd.matrixU(), svd.matrixV(), svd.singularValues()[1] / svd.singularValues()[0]};
  const auto linearize = [&](const RankTwo& at, NormalEquations<7>& result) {
    const Eigen::Matrix3d matrix = at.matrix();
    float D[7][9];
    for (int k = 0; k < 3; ++k) {
      const Eigen::Matrix3d generator = crossMatrix(Eigen::Vector3d::Unit(k));
      toFloat(generator * matrix, D[k]);
      toFloat(-matrix * generator, D[3 + k]);
    }
    toFloat(at.U.col(1) * at.V.col(1).transpose(), D[6]);
    kernels_.linearizeFundamental(points_, FloatMatrix(matrix).entry, D, loss, result);
  };
  const auto cost = [&](const RankTwo& at) {
    return kernels_.epipolarCost(points_, FloatMatrix(at.matrix()).entry, loss);
  };
  const auto moved = [](const RankTwo& from, const double(&step)[7]) {
    return RankTwo{rotationFromVector({step[0], step[1], step[2]}) * from.U,
                   rotationFromVector({step[3], step[4], step[5]}) * from.V, from.s + step[6]};
  };
  points_.countPasses(minimizeRobustCost<7>(iterations, kEnough, state, linearize, cost, moved));
  const Eigen::Matrix3d matrix = state.matrix();
  F = matrix / matrix.norm();
}

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
                            HypothesisScore& score) const {
  const FloatMatrix H(hypothesis.matrix), inverse(hypothesis.matrix.inverse());
  kernels_.scoreHomography(points, H.entry, inverse.entry, bound, score);
  points.countResiduals(score.evaluated);
  return score.cost < bound;  // false also for the NaN of a singular matrix
}

bool HomographyModel::fits(const Hypothesis& hypothesis, int slot) const {
  points_.countResiduals(1);
  return points_.weight[slot] * transferSquared(hypothesis.matrix, hypothesis.matrix.inverse(), points_.x1[slot],
                                                points_.y1[slot], points_.x2[slot], points_.y2[slot]) <
         1;
}

void HomographyModel::residuals(const Hypothesis& hypothesis, std::vector<float>& e) const {
  e.resize(static_cast<size_t>(points_.size));
  kernels_.transferResiduals(points_, FloatMatrix(hypothesis.matrix).entry, e.data());
  points_.countPasses(1);
}

void HomographyModel::refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const {
  Eigen::Matrix3d& H = hypothesis.matrix;
  // The scale is fixed by the entry of largest size; the other eight are free.
  int fixed = 0;
  for (int k = 1; k < 9; ++k) {
    if (std::abs(H(k / 3, k % 3)) > std::abs(H(fixed / 3, fixed % 3))) fixed = k;
  }
  const auto entry = [fixed](int parameter) { return parameter < fixed ? parameter : parameter + 1; };
  const auto linearize = [&](const Eigen::Matrix3d& at, NormalEquations<8>& result) {
    float D[8][9] = {};
    for (int k = 0; k < 8; ++k) D[k][entry(k)] = 1;
    kernels_.linearizeHomography(points_, FloatMatrix(at).entry, D, loss, result);
  };
  const auto cost = [&](const Eigen::Matrix3d& at) {
    return kernels_.transferCost(points_, FloatMatrix(at).entry, loss);
  };
  const auto moved = [&entry](const Eigen::Matrix3d& from, const double(&step)[8]) {
    Eigen::Matrix3d to = from;
    for (int k = 0; k < 8; ++k) to(entry(k) / 3, entry(k) % 3) += step[k];
    return to;
  };
  points_.countPasses(minimizeRobustCost<8>(iterations, kEnough, H, linearize, cost, moved));
  H /= H.norm();
}

}  // namespace gms_ransac
