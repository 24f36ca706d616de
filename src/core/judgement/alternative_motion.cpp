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
/// Costs end at the threshold, or at so many deviations of the noise where that is less.
constexpr double kMostDeviations = 3;
/// Motions that are closer in direction, in standard deviations or radians, are the same that has not converged.
constexpr double kSameSigmas = 5, kLeastApart = 3 * M_PI / 180;

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

double AlternativeMotions::Comparison::apart(const TwoViewPose& motion) const {
  // Of the opposite direction, with a turn that makes up for it, is another motion: near and far changed places.
  return std::acos(std::clamp(motion.t.dot(judged.pose.t), -1.0, 1.0));
}

Ambiguity AlternativeMotions::compare(const JudgedPose& judged, const PointColumnsView& plausible,
                                      const std::vector<AlternativeMotion>& alternatives, int64_t& evaluations) {
  residuals_.resize(judged.noise.residuals().size());
  const double same_within =
      std::clamp(kSameSigmas * directionSigma(judged.spread.of_matches), kLeastApart, kOtherDirection);
  const Comparison comparison = {judged, plausible, same_within, evaluations};
  Ambiguity ambiguity;
  for (const AlternativeMotion& alternative : alternatives) {
    TwoViewPose motion = alternative.pose;
    if (!explainsAsWell(comparison, alternative.of_plane ? kLeastVuongOnPlane : kLeastVuong, motion)) continue;
    ambiguity.other_direction |= comparison.apart(motion) > kOtherDirection;
    const Eigen::Matrix<double, 5, 1> step = poseStep(judged.pose, motion);
    ambiguity.covariance += step * step.transpose();
  }
  return ambiguity;
}

bool AlternativeMotions::explainsAsWell(const Comparison& comparison, double least, TwoViewPose& motion) {
  const int count = comparison.plausible.count;
  if (comparison.isSame(motion) ||
      !isNoWorse(comparison, std::min(kFirstMatches, count), kFirstIterations, kDropBeyond, motion) ||
      !isNoWorse(comparison, count, kFurtherIterations, least, motion)) {
    return false;
  }
  const Loss loss = comparison.judged.noise.loss();
  const int passes = PoseModel(kernels_, comparison.plausible).refine(loss, kFinalIterations, motion, kEnough);
  comparison.evaluations += static_cast<int64_t>(count) * passes;
  return true;
}

bool AlternativeMotions::isNoWorse(const Comparison& comparison, int count, int iterations, double least,
                                   TwoViewPose& motion) {
  const JudgedPose& judged = comparison.judged;
  const PointColumnsView plausible = firstColumns(comparison.plausible, count);
  const int passes = PoseModel(kernels_, plausible).refine(judged.noise.loss(), iterations, motion);
  comparison.evaluations += static_cast<int64_t>(count) * (passes + 1);
  if (comparison.isSame(motion)) return false;
  PoseModel(kernels_, firstColumns(judged.points.view(), count)).residualsInFront(motion, residuals_.data());
  return vuong(judged, count) < least;
}

double AlternativeMotions::vuong(const JudgedPose& judged, int count) {
  const MatchNoise& noise = judged.noise;
  const auto per_cost =
      static_cast<float>(std::max(1.0, 1 / (kMostDeviations * kMostDeviations * noise.sigma() * noise.sigma())));
  const auto cost = [per_cost](float residual) { return std::min(per_cost * residual, 1.f); };
  return vuongStatistic(count, judged.points.cells(), by_cell_, [&](size_t i) {
    return noise.plausible(static_cast<int>(i)) ? cost(residuals_[i]) - cost(noise.residuals()[i]) : 0.f;
  });
}

}  // namespace gms_ransac
