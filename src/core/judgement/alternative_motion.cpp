#include "judgement/alternative_motion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace gms_ransac {

namespace {

// What the statistic of Vuong's test must reach for the pose to count as better; measured in doc/estimator.md.
constexpr double kLeastVuong = 0.75;
constexpr double kLeastVuongOnPlane = 2.5;
constexpr Loss kAlternativeLoss = {4, 1};
// A few steps on a part of the matches show which cannot come near: those that lose by so much there.
constexpr int kFirstMatches = 256;
constexpr int kFirstIterations = 2;
constexpr int kFurtherIterations = 5, kFinalIterations = 10;
constexpr double kDropBeyond = 3;
constexpr double kMostDeviations = 3;

/// The statistic of Vuong's test of non-nested models (Econometrica 1989) for the first residuals against the second:
/// the sum of the differences of truncated costs over the root of the sum of their squares, not centred, each cell one
/// observation. At most the root of the number of cells.
double vuongStatistic(const std::vector<float>& first, const std::vector<float>& second, int count, float per_cost,
                      const std::vector<int32_t>& cells, std::vector<double>& by_cell) {
  by_cell.clear();
  double sum = 0, squares = 0;
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const auto cell = static_cast<size_t>(cells[i]);
    if (cell >= by_cell.size()) by_cell.resize(cell + 1, 0.0);
    const double difference = std::min(per_cost * second[i], 1.f) - std::min(per_cost * first[i], 1.f);
    by_cell[cell] += difference;
    sum += difference;
  }
  for (double difference : by_cell) squares += difference * difference;
  return squares > 0 ? sum / std::sqrt(squares) : 0;
}

/// From one pose to another in the parameters of PoseModel::linearize.
Eigen::Matrix<double, 5, 1> poseStep(const TwoViewPose& from, const TwoViewPose& to) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to.R * from.R.transpose()));
  const Eigen::Vector3d t = to.t.dot(from.t) < 0 ? Eigen::Vector3d(-to.t) : to.t;
  Eigen::Vector3d basis[2];
  PoseModel::tangent(from.t, basis);
  Eigen::Matrix<double, 5, 1> step;
  step << turn.angle() * turn.axis(), basis[0].dot(t), basis[1].dot(t);
  return step;
}

}  // namespace

Ambiguity findAlternativeMotion(const ResidualKernels& kernels, const PointColumnsView& points, const TwoViewPose& pose,
                                const MatchNoise& noise, const std::vector<AlternativeMotion>& alternatives,
                                const std::vector<int32_t>& cells, double same_within, AlternativeBuffers& work,
                                int64_t& evaluations) {
  Ambiguity ambiguity;
  // Costs end at the threshold, or at three deviations of the noise where that is less.
  const auto per_cost =
      static_cast<float>(std::max(1.0, 1 / (kMostDeviations * kMostDeviations * noise.sigma() * noise.sigma())));
  // The sign of t does not matter here: a pose with the wrong one has the matches behind the cameras and loses.
  const auto apart = [&](const TwoViewPose& other) { return std::acos(std::min(1.0, std::abs(other.t.dot(pose.t)))); };
  // Refines an alternative on some of the matches; false where Vuong's statistic of the pose against it reaches `most`,
  // or it came to be much the same motion.
  const auto isNoWorse = [&](const PointColumnsView& part, int iterations, double most, TwoViewPose& alternative) {
    const PoseModel model(kernels, part);
    evaluations += static_cast<int64_t>(part.count) * (model.refine(kAlternativeLoss, iterations, alternative) + 1);
    if (apart(alternative) < same_within) return false;
    model.residualsInFront(alternative, work.residuals.data());
    return vuongStatistic(noise.residuals(), work.residuals, part.count, per_cost, cells, work.by_cell) < most;
  };
  for (const AlternativeMotion& candidate : alternatives) {
    const double least = candidate.of_plane ? kLeastVuongOnPlane : kLeastVuong;
    TwoViewPose alternative = candidate.pose;
    if (apart(alternative) < same_within ||
        !isNoWorse(firstColumns(points, kFirstMatches), kFirstIterations, kDropBeyond, alternative) ||
        !isNoWorse(points, kFurtherIterations, least, alternative)) {
      continue;
    }
    evaluations += static_cast<int64_t>(points.count) *
                   PoseModel(kernels, points).refine(kAlternativeLoss, kFinalIterations, alternative, kEnough);
    ambiguity.other_direction |= apart(alternative) > kOtherDirection;
    const Eigen::Matrix<double, 5, 1> step = poseStep(pose, alternative);
    ambiguity.covariance += step * step.transpose();
  }
  return ambiguity;
}

}  // namespace gms_ransac
