#include "judgement/alternative_motion.h"

#include <algorithm>
#include <cmath>

#include "judgement/vuong.h"

namespace gms_ransac {

namespace {

// What the statistic of Vuong's test must reach for the pose to count as better; measured in doc/estimator.md.
constexpr double kLeastVuong = 0.75;
constexpr double kLeastVuongOnPlane = 2.5;
// A few steps on a part of the matches show which cannot come near: those that lose by so much there.
constexpr int kFirstMatches = 256;
constexpr int kFirstIterations = 2;
constexpr int kFurtherIterations = 5, kFinalIterations = 10;
constexpr double kDropBeyond = 3;
constexpr double kMostDeviations = 3;

/// From one pose to another in the parameters of PoseModel::linearize.
Eigen::Matrix<double, 5, 1> poseStep(const TwoViewPose& from, const TwoViewPose& to) {
  const Eigen::Vector3d t = to.t.dot(from.t) < 0 ? Eigen::Vector3d(-to.t) : to.t;
  Eigen::Vector3d basis[2];
  PoseModel::tangent(from.t, basis);
  Eigen::Matrix<double, 5, 1> step;
  step << rotationVector(to.R * from.R.transpose()), basis[0].dot(t), basis[1].dot(t);
  return step;
}

}  // namespace

Ambiguity findAlternativeMotion(const ResidualKernels& kernels, const PointColumnsView& points,
                                const PointColumnsView& plausible, const TwoViewPose& pose, const MatchNoise& noise,
                                const std::vector<AlternativeMotion>& alternatives, const std::vector<int32_t>& cells,
                                double same_within, AlternativeBuffers& work, int64_t& evaluations) {
  Ambiguity ambiguity;
  // Costs end at the threshold, or at three deviations of the noise where that is less.
  const auto per_cost =
      static_cast<float>(std::max(1.0, 1 / (kMostDeviations * kMostDeviations * noise.sigma() * noise.sigma())));
  const auto cost = [&](float residual) { return std::min(per_cost * residual, 1.f); };
  const auto excess = [&](size_t i) {
    return noise.plausible(static_cast<int>(i)) ? cost(work.residuals[i]) - cost(noise.residuals()[i]) : 0.f;
  };
  const Loss loss = noise.loss();
  // Of the opposite direction, with a turn that makes up for it, is another motion: near and far changed places.
  const auto apart = [&](const TwoViewPose& other) { return std::acos(std::clamp(other.t.dot(pose.t), -1.0, 1.0)); };
  // Refines an alternative on some of the matches; false where Vuong's statistic of the pose against it reaches `most`,
  // or it came to be much the same motion.
  const auto isNoWorse = [&](int count, int iterations, double most, TwoViewPose& alternative) {
    const int passes = PoseModel(kernels, firstColumns(plausible, count)).refine(loss, iterations, alternative);
    evaluations += static_cast<int64_t>(count) * (passes + 1);
    if (apart(alternative) < same_within) return false;
    PoseModel(kernels, firstColumns(points, count)).residualsInFront(alternative, work.residuals.data());
    return vuongStatistic(count, cells, work.by_cell, excess) < most;
  };
  for (const AlternativeMotion& candidate : alternatives) {
    const double least = candidate.of_plane ? kLeastVuongOnPlane : kLeastVuong;
    TwoViewPose alternative = candidate.pose;
    if (apart(alternative) < same_within ||
        !isNoWorse(std::min(kFirstMatches, points.count), kFirstIterations, kDropBeyond, alternative) ||
        !isNoWorse(points.count, kFurtherIterations, least, alternative)) {
      continue;
    }
    evaluations += static_cast<int64_t>(points.count) *
                   PoseModel(kernels, plausible).refine(loss, kFinalIterations, alternative, kEnough);
    ambiguity.other_direction |= apart(alternative) > kOtherDirection;
    const Eigen::Matrix<double, 5, 1> step = poseStep(pose, alternative);
    ambiguity.covariance += step * step.transpose();
  }
  return ambiguity;
}

}  // namespace gms_ransac
