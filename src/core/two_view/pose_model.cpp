#include "two_view/pose_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "two_view/levenberg_marquardt.h"
#include "two_view/solvers/minimal_solvers.h"
#include "two_view/two_view_model.h"

namespace gms_ransac {

namespace {

// Displacement beyond the rotation, in thresholds, within which a sample point may count as infinitely far.
constexpr float kFarThresholds = 2;

/// True when all sample points lie in front of both cameras for (R, sign t), or too far to tell.
bool inFront(const PointColumnsView& points, const int* sample, int size, const Eigen::Matrix3d& R,
             const Eigen::Vector3d& t, double& sign) {
  bool plus = true, minus = true;
  for (int k = 0; k < size && (plus || minus); ++k) {
    const int slot = sample[k];
    const Eigen::Vector3d q(points.x2[slot], points.y2[slot], 1);
    const Eigen::Vector3d p = R * Eigen::Vector3d(points.x1[slot], points.y1[slot], 1);
    const Eigen::Vector3d m = q.cross(p);
    const double far = kFarThresholds * kFarThresholds * p.z() * p.z();
    if (p.z() > 0 && points.weight[slot] * m.head<2>().squaredNorm() < far) continue;
    const double depth_reference = -m.dot(q.cross(t)), depth_current = m.dot(t.cross(p));
    plus = plus && depth_reference > 0 && depth_current > 0;
    minus = minus && depth_reference < 0 && depth_current < 0;
  }
  sign = plus ? 1 : -1;
  return plus || minus;
}

}  // namespace

Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d rotationFromVector(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + crossMatrix(v);
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

Eigen::Vector3d rotationVector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Eigen::Matrix<double, 6, 6> leverTransform(const Eigen::Matrix3d& R, const Eigen::Vector3d& lever) {
  Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Zero();
  m.topLeftCorner<3, 3>() = m.bottomRightCorner<3, 3>() = R;
  m.topRightCorner<3, 3>() = -R * crossMatrix(lever);
  return m;
}

RelativePose chained(const RelativePose& b_in_a, const RelativePose& c_in_b) {
  const Eigen::Vector3d lever = b_in_a.R * c_in_b.t;
  const Eigen::Matrix<double, 6, 6> A = leverTransform(Eigen::Matrix3d::Identity(), lever);
  const Eigen::Matrix<double, 6, 6> B = leverTransform(b_in_a.R, Eigen::Vector3d::Zero());
  RelativePose c_in_a;
  c_in_a.R = Eigen::Quaterniond(b_in_a.R * c_in_b.R).normalized().toRotationMatrix();
  c_in_a.t = b_in_a.t + lever;
  c_in_a.covariance = A * b_in_a.covariance * A.transpose() + B * c_in_b.covariance * B.transpose();
  return c_in_a;
}

bool makeRotation(Eigen::Matrix3d& R) {
  // Newton and Schulz's iteration for the polar factor squares the error each time.
  constexpr double kReach = 0.5, kRounding = 1e-14;
  constexpr int kSteps = 6;
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Matrix3d error = R.transpose() * R - Eigen::Matrix3d::Identity();
    const double size = error.cwiseAbs().maxCoeff();
    if (size < kRounding) return R.determinant() > 0;
    if (!(size < kReach)) return false;
    R -= 0.5 * R * error;
  }
  return R.determinant() > 0;
}

MotionStart::MotionStart(const TwoViewPose& pose) : R_(pose.R), t_(pose.t) {}

TwoViewPose MotionStart::pose() const { return {R_, t_}; }

Eigen::Matrix3d TwoViewPose::essential() const { return crossMatrix(t) * R; }

PoseParameters TwoViewPose::parameters() const {
  PoseParameters p;
  toFloat(R, p.R);
  toFloat(essential(), p.E);
  for (int i = 0; i < 3; ++i) p.t[i] = static_cast<float>(t[i]);
  return p;
}

int PoseModel::solve(const int* sample, Hypothesis* hypotheses) const {
  const MinimalSample<5> points(points_, sample);
  Eigen::Matrix3d models[kMaxHypotheses];
  const int solutions = solveEssential5(points.reference, points.current, models);
  int count = 0;
  for (int k = 0; k < solutions; ++k) {
    EssentialDecomposition d = decomposeEssential(models[k]);
    double sign;
    for (Eigen::Matrix3d* R : {&d.R1, &d.R2}) {
      if (!inFront(points_, sample, 5, *R, d.t, sign)) continue;
      // A root that is inaccurate leaves a matrix that is not quite essential, and what comes of it no rotation.
      if (!makeRotation(*R)) continue;
      hypotheses[count++].pose = {*R, sign * d.t};
      break;
    }
  }
  return count;
}

bool PoseModel::score(const PointColumnsView& points, const TwoViewPose& pose, float bound,
                      HypothesisScore& score) const {
  const PoseParameters parameters = pose.parameters();
  if (bound < static_cast<float>(points.count)) {
    // Without cheirality and prior the cost is a lower bound, and half the work.
    kernels_.scoreEpipolar(points, parameters.E, bound, score);
    points.countResiduals(score.evaluated);
    if (!(score.cost < bound)) return false;
  }
  kernels_.scorePose(points, parameters, prior_, bound, score);
  points.countResiduals(score.evaluated);
  return score.cost < bound;
}

TwoViewPose PoseModel::withBetterSign(const TwoViewPose& pose, float& cost) const {
  const TwoViewPose opposite = {pose.R, -pose.t};
  HypothesisScore score, opposite_score;
  kernels_.scorePose(points_, pose.parameters(), prior_, std::numeric_limits<float>::max(), score);
  // The wrong one has the matches behind a camera, and is given up after the first of them.
  kernels_.scorePose(points_, opposite.parameters(), prior_, score.cost, opposite_score);
  points_.countResiduals(score.evaluated + opposite_score.evaluated);
  cost = std::min(score.cost, opposite_score.cost);
  return opposite_score.cost < score.cost ? opposite : pose;
}

void PoseModel::residualsInFront(const TwoViewPose& pose, std::vector<float>& e) const {
  e.resize(static_cast<size_t>(points_.size));
  kernels_.poseResiduals(points_, pose.parameters(), e.data());
  points_.countPasses(1);
}

void PoseModel::tangent(const Eigen::Vector3d& t, float (&steps)[2][3]) {
  Eigen::Vector3d basis[2];
  tangent(t, basis);
  for (int k = 0; k < 6; ++k) steps[k / 3][k % 3] = static_cast<float>(basis[k / 3][k % 3]);
}

void PoseModel::tangent(const Eigen::Vector3d& t, Eigen::Vector3d (&basis)[2]) {
  int smallest;
  t.cwiseAbs().minCoeff(&smallest);
  basis[0] = t.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  basis[1] = t.cross(basis[0]);
}

void PoseModel::linearize(const TwoViewPose& pose, const Loss& loss, NormalEquations<5>& equations) const {
  float steps[2][3];
  tangent(pose.t, steps);
  kernels_.linearizePose(points_, pose.parameters(), steps, loss, prior_, equations);
}

DerivativeSums PoseModel::differentiate(const TwoViewPose& pose, const Loss& loss, float* columns) const {
  float steps[2][3];
  tangent(pose.t, steps);
  return kernels_.differentiatePose(points_, pose.parameters(), steps, loss, columns);
}

void PoseModel::refine(const Loss& loss, int iterations, TwoViewPose& pose, float enough) const {
  makeRotation(pose.R);  // steps keep what it is, errors included
  points_.countPasses(minimizeRobustCost<5>(
      iterations, enough, pose, [&](const TwoViewPose& at, NormalEquations<5>& result) { linearize(at, loss, result); },
      [&](const TwoViewPose& at) { return kernels_.poseCost(points_, at.parameters(), loss, prior_); },
      [](const TwoViewPose& from, const double(&step)[5]) {
        Eigen::Vector3d basis[2];
        tangent(from.t, basis);
        return TwoViewPose{rotationFromVector({step[0], step[1], step[2]}) * from.R,
                           (from.t + step[3] * basis[0] + step[4] * basis[1]).normalized()};
      }));
}

void PoseModel::linearizeRotation(const Eigen::Matrix3d& R, const Loss& loss, NormalEquations<3>& equations) const {
  kernels_.linearizeRotation(points_, FloatMatrix(R).entry, loss, equations);
}

void PoseModel::refineRotation(const Loss& loss, int iterations, Eigen::Matrix3d& R) const {
  points_.countPasses(minimizeRobustCost<3>(
      iterations, kEnoughToCompare, R,
      [&](const Eigen::Matrix3d& at, NormalEquations<3>& result) { linearizeRotation(at, loss, result); },
      [&](const Eigen::Matrix3d& at) { return kernels_.transferCost(points_, FloatMatrix(at).entry, loss); },
      [](const Eigen::Matrix3d& from, const double(&step)[3]) {
        return Eigen::Matrix3d(rotationFromVector({step[0], step[1], step[2]}) * from);
      }));
}

int EssentialModel::solve(const int* sample, Hypothesis* hypotheses) const {
  const MinimalSample<5> points(points_, sample);
  Eigen::Matrix3d models[kMaxHypotheses];
  return keepFinite(models, solveEssential5(points.reference, points.current, models), hypotheses);
}

void PoseModel::rotationResiduals(const Eigen::Matrix3d& R, std::vector<float>& e) const {
  e.resize(static_cast<size_t>(points_.size));
  kernels_.transferResiduals(points_, FloatMatrix(R).entry, e.data());
  points_.countPasses(1);
}

}  // namespace gms_ransac
