#include "two_view/fundamental_model.h"

#include <algorithm>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "two_view/levenberg_marquardt.h"
#include "two_view/minimal_sample.h"
#include "two_view/pose_model.h"
#include "two_view/solvers/fundamental_7pt.h"

namespace gms_ransac {

namespace {

/// A rank-two matrix U diag(1, s, 0) V^T.
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
    const int i = sample[k];
    const Eigen::Vector3d line = F * Eigen::Vector3d(points.x1[i], points.y1[i], 1);
    positive += line.dot(epipole.cross(Eigen::Vector3d(points.x2[i], points.y2[i], 1))) > 0;
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

int FundamentalModel::refine(const Loss& loss, int iterations, Hypothesis& hypothesis) const {
  Eigen::Matrix3d& F = hypothesis.matrix;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[0] > 0)) return 0;
  RankTwo state{svd.matrixU(), svd.matrixV(), svd.singularValues()[1] / svd.singularValues()[0]};
  const auto linearize = [&](const RankTwo& at, NormalEquations<7>& result) {
    const Eigen::Matrix3d matrix = at.matrix();
    float m[9], D[7][9];
    toFloat(matrix, m);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Matrix3d generator = crossMatrix(Eigen::Vector3d::Unit(k));
      toFloat(generator * matrix, D[k]);
      toFloat(-matrix * generator, D[3 + k]);
    }
    toFloat(at.U.col(1) * at.V.col(1).transpose(), D[6]);
    kernels_.linearizeFundamental(points_, m, D, loss, result);
  };
  const auto cost = [&](const RankTwo& at) {
    float m[9];
    toFloat(at.matrix(), m);
    return kernels_.epipolarCost(points_, m, loss);
  };
  const auto moved = [](const RankTwo& from, const double(&step)[7]) {
    return RankTwo{rotationFromVector({step[0], step[1], step[2]}) * from.U,
                   rotationFromVector({step[3], step[4], step[5]}) * from.V, from.s + step[6]};
  };
  const int passes = minimizeRobustCost<7>(iterations, kEnough, state, linearize, cost, moved);
  const Eigen::Matrix3d matrix = state.matrix();
  F = matrix / matrix.norm();
  return passes;
}

}  // namespace gms_ransac
