#include "judgement/other_motions.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "judgement/vuong.h"
#include "ransac/proposals.h"

namespace gms_ransac {

namespace {

/// The statistic at which the pose counts as better. The limit is kSurelyBetter if chance or an error of the camera may
/// make the wrong motion fit better: the other motion of a plane, near and far exchanged.
constexpr double kLeastVuong = 0.75;
/// So many steps on a part of the matches show which cannot come near: those that are surely worse there.
constexpr int kFirstIterations = 2;
/// Motions whose directions are closer, in standard deviations, are one that has not converged.
constexpr double kSameSigmas = 5;

/// The opposite direction is another motion: with a rotation that compensates for it, near and far change places.
double angleBetween(const TwoViewPose& a, const TwoViewPose& b) {
  return std::acos(std::clamp(a.t.dot(b.t), -1.0, 1.0));
}

/// From one pose to another in the parameters of PoseModel::linearize.
PoseVector poseStep(const TwoViewPose& from, const TwoViewPose& to) {
  const Eigen::Vector3d t = to.t.dot(from.t) < 0 ? Eigen::Vector3d(-to.t) : to.t;
  Eigen::Vector3d basis[2];
  PoseModel::tangent(from.t, basis);
  PoseVector step;
  step << rotationVector(to.R * from.R.transpose()), basis[0].dot(t), basis[1].dot(t);
  return step;
}

}  // namespace

Ambiguity OtherMotions::compare(const RefinedPose& refined, double direction_sigma, bool camera_decides,
                                const std::vector<AlternativeMotion>& alternatives) {
  const int count = refined.points.size();
  const double same_within = std::min(kSameSigmas * direction_sigma, kOtherDirection);
  Ambiguity ambiguity;
  for (const AlternativeMotion& alternative : alternatives) {
    TwoViewPose motion = alternative.pose;
    if (angleBetween(motion, refined.pose) < same_within) continue;
    const int first = std::min(kRandomPart, count);
    if (against(refined, same_within, first, kFirstIterations, motion) >= kSurelyBetter) continue;
    const double better = against(refined, same_within, count, kFinalIterations, motion);
    const bool by_chance = alternative.of_plane || (camera_decides && motion.t.dot(refined.pose.t) < 0);
    if (better >= (by_chance ? kSurelyBetter : kLeastVuong)) continue;
    PoseModel(kernels_, refined.plausible).refine(refined.noise.loss(), kFinalIterations, motion, kEnough);
    ambiguity.other_direction |= angleBetween(motion, refined.pose) > kOtherDirection;
    const PoseVector step = poseStep(refined.pose, motion);
    ambiguity.covariance += step * step.transpose();
  }
  return ambiguity;
}

double OtherMotions::against(const RefinedPose& refined, double same_within, int count, int iterations,
                             TwoViewPose& motion) {
  const MatchNoise& noise = refined.noise;
  PoseModel(kernels_, firstColumns(refined.plausible, count)).refine(noise.loss(), iterations, motion);
  if (angleBetween(motion, refined.pose) < same_within) return std::numeric_limits<double>::infinity();
  PoseModel(kernels_, firstColumns(refined.points.view(), count)).residualsInFront(motion, residuals_);
  // Costs end at the threshold, or at kMostCost where that is less: a homography's threshold is many times the noise.
  const double most = static_cast<double>(kMostCost) * noise.sigma() * noise.sigma();
  const auto per_cost = static_cast<float>(std::max(1.0, 1 / most));
  const auto cost = [per_cost](float residual) { return std::min(per_cost * residual, 1.f); };
  return vuongStatistic(count, refined.points.cells(), by_cell_, [&](size_t i) {
    return noise.plausible(static_cast<int>(i)) ? cost(residuals_[i]) - cost(noise.residuals()[i]) : 0.f;
  });
}

double OtherMotions::shareOfSecond(const PointColumnsView& points, const MatchNoise& noise, double least) {
  rest_.clear();
  for (int i = 0; i < points.count; ++i) {
    if (noise.probabilities()[static_cast<size_t>(i)] < 0.5f) rest_.push_back(i);
  }
  const int rest = static_cast<int>(rest_.size()), explained = points.count - rest;
  if (rest < least * explained) return 0;
  rest_points_.gather(points, rest_.data(), rest);
  findMotionStarts(kernels_, rest_points_.view(), motions_);
  int most = 0;
  for (TwoViewPose& motion : motions_) {
    const PoseModel model(kernels_, rest_points_.view());
    model.refine(kRobustLoss, kFinalIterations, motion);
    model.residualsInFront(motion, residuals_);
    most = std::max(most, static_cast<int>(std::count_if(residuals_.begin(), residuals_.begin() + rest,
                                                         [](float residual) { return residual < 1; })));
  }
  return static_cast<double>(most) / explained;
}

}  // namespace gms_ransac
