#include "robust/fast/fundamental_model.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "robust/fast/levenberg_marquardt.h"
#include "robust/fast/pose_model.h"
#include "robust/solvers/fundamental_7pt.h"

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

int FundamentalModel::generate(const int* sample, Hypothesis* hypotheses) const {
  double x1[7][2], x2[7][2];
  for (int k = 0; k < 7; ++k) {
    const int i = sample[k];
    x1[k][0] = points_.x1[i];
    x1[k][1] = points_.y1[i];
    x2[k][0] = points_.x2[i];
    x2[k][1] = points_.y2[i];
  }
  const int solutions = solveFundamental7(x1, x2, hypotheses);
  int count = 0;
  for (int k = 0; k < solutions; ++k) {
    if (oriented(hypotheses[k], points_, sample, kSampleSize)) hypotheses[count++] = hypotheses[k];
  }
  return count;
}

bool FundamentalModel::score(const Hypothesis& F, float bound, Score& score, int64_t& evaluations) const {
  float m[9];
  toFloat(F, m);
  kernels_.scoreEpipolar(points_, m, bound, score);
  evaluations += score.evaluated;
  return score.cost < bound;
}

void FundamentalModel::residuals(const Hypothesis& F, float* e) const {
  float m[9];
  toFloat(F, m);
  kernels_.epipolarResiduals(points_, m, e);
}

int FundamentalModel::refine(const Loss& loss, int iterations, Hypothesis& F) const {
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
  const auto moved = [](const RankTwo& from, const double(&step)[7]) {
    return RankTwo{rotationFromVector({step[0], step[1], step[2]}) * from.U,
                   rotationFromVector({step[3], step[4], step[5]}) * from.V, from.s + step[6]};
  };
  NormalEquations<7> equations;
  const int passes = minimizeRobustCost<7>(iterations, kEnough, state, equations, linearize, moved);
  const Eigen::Matrix3d matrix = state.matrix();
  F = matrix / matrix.norm();
  return passes;
}

}  // namespace gms_ransac
