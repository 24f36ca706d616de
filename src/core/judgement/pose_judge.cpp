#include "judgement/pose_judge.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "two_view/translation_variance.h"

namespace gms_ransac {

namespace {

constexpr double kDegree = M_PI / 180;
/// With a larger uncertainty, the three axes together, a rotation is unusable.
constexpr double kMostRotationSigma = 1 * kDegree;
/// From this contradiction on the errors of the camera exceed the typical ones, and the rotation must be known in spite
/// of them.
constexpr double kBeyondCameras = 10;
/// Largest support of another motion among the other matches, as a share of the pose's own. The second limit holds if
/// the matches contradict the camera, because the pose may then join two bodies.
constexpr double kMostOfSecond = 0.8, kMostOfSecondJoined = 0.6;
/// Where a part of the view contradicts the rest, both have to know the direction by themselves to this standard
/// deviation. A direction that is neither's fits as well: the body has much parallax, and what stands still has little.
constexpr double kKnownByItself = 4 * kDegree;
/// Squared Mahalanobis distance by degree of freedom at which a preference is followed half way.
constexpr double kHalfWay = 4;

/// Measures the noise at a pose.
void measureNoise(const TwoViewPose& pose, RefinedPose& refined) {
  refined.pose = pose;
  refined.noise.measure(refined.model(), pose, refined.bodies.of_other);
  refined.plausible.copy(refined.points->view(), [&](int slot) { return refined.noise.plausible(slot); });
}

/// True if an optimum of the usual loss is also one of the loss that the noise asks for: their softness is equal, and
/// no implausible match has a weight.
bool atOptimum(const RefinedPose& refined) {
  const Loss loss = refined.noise.loss();
  if (loss.inverse_softness != 1) return false;
  for (int slot = 0; slot < refined.points->size(); ++slot) {
    const float residual = refined.noise.residuals()[static_cast<size_t>(slot)];
    if (!refined.noise.plausible(slot) && residual < loss.cut) return false;
  }
  return true;
}

/// Noise and covariance at a pose or, with `move`, at the optimum of the loss that the noise asks for.
void measure(const RobustOptions& options, bool move, TwoViewPose pose, RefinedPose& refined) {
  measureNoise(pose, refined);
  if (move && !atOptimum(refined)) {
    refined.plausibleModel().refine(refined.noise.loss(), kFinalIterations, pose, kEnough);
    measureNoise(pose, refined);
  }
  const double variance = refined.noise.variance();
  refined.information.sum(refined.kernels, refined.plausible.view(), pose, refined.noise.loss(),
                          refined.points->cells());
  refined.covariance = poseCovariance(refined.information, variance, options.calibration_sigma);
  if (options.judge) refined.worst_break = findBreak(refined.information, variance);
}

bool rotationIsKnown(const PoseCovariance& known) {
  const PoseSquare& covariance = known.camera.statistic < kBeyondCameras ? known.of_matches : known.covariance;
  return covariance.topLeftCorner<3, 3>().trace() <= kMostRotationSigma * kMostRotationSigma;
}

/// Returns the pose with its rotation moved towards the preferred one, and the covariance widened by the step.
RelativePose publish(const RefinedPose& refined, const TwoViewPose& preferred, PoseSquare covariance) {
  // The reason for the preferred rotation is a guess about the scene, which a clear optimum overrules: it is followed
  // the less the further it is from the optimum in terms of the optimum's own covariance. How far that goes may all be
  // error.
  const TwoViewPose& optimum = refined.pose;
  Eigen::Vector3d step = rotationVector(preferred.R * optimum.R.transpose());
  if (refined.bodies.found()) step.setZero();  // the preference is that of both bodies
  const Eigen::Matrix3d own = refined.covariance.naive.topLeftCorner<3, 3>();
  const double distance = step.dot(own.llt().solve(step)) / 3;
  step = std::isfinite(distance) ? Eigen::Vector3d(step / (1 + distance / kHalfWay)) : Eigen::Vector3d::Zero();
  covariance.topLeftCorner<3, 3>() += step * step.transpose();
  const Eigen::Matrix3d R = rotationFromVector(step) * optimum.R;
  // The direction in the reference camera stays that of the optimum.
  RelativePose pose = fromReferenceToCurrent(R, R * optimum.R.transpose() * optimum.t);
  pose.covariance = relativeCovariance(optimum, covariance);
  return pose;
}

/// The pose of a rotation whose translation is a guess: in the reference camera its direction stays that of `optimum`.
RelativePose publishRotation(const TwoViewPose& optimum, const Explanation& explanation) {
  const Eigen::Matrix3d& R = explanation.R;
  RelativePose pose = fromReferenceToCurrent(R, R * optimum.R.transpose() * optimum.t);
  pose.covariance.bottomRightCorner<3, 3>() = R.transpose() * explanation.covariance * R;
  return pose;
}

}  // namespace

PoseJudge::PoseJudge(const RobustOptions& options) : options_(options), refined_(residualKernels(options.simd)) {}

const RefinedPose& PoseJudge::refine(const TwoViewPoints& points, bool move, const TwoViewPose& pose) {
  refined_.points = &points;
  refined_.bodies.of_other.clear();
  measure(options_, move, pose, refined_);
  if (!move || !options_.judge) return refined_;
  segmentation_.find(refined_, refined_.bodies);
  if (refined_.bodies.found()) measure(options_, true, refined_.bodies.larger, refined_);
  return refined_;
}

const Judgement& PoseJudge::judge(const RefinedPose& refined, const TwoViewPose& preferred,
                                  const std::vector<AlternativeMotion>& alternatives, bool shutter_may_roll) {
  fitRotation(refined, alone_);
  const Verdict verdict = options_.judge ? compare(refined, alternatives, shutter_may_roll) : Verdict();
  const DirectionDoubt reason = options_.judge ? doubt(refined, verdict) : DirectionDoubt::kNone;
  judgement_.pose = reason == DirectionDoubt::kNone
                        ? publish(refined, preferred, refined.covariance.covariance + verdict.spread)
                        : publishRotation(refined.pose, rotationWithoutTranslation(refined, alone_, verdict));
  return conclude(refined, reason, verdict.onlyRotated());
}

const Judgement& PoseJudge::judgeRotation(const TwoViewPoints& points, const Eigen::Matrix3d& R) {
  refined_.points = &points;
  refined_.bodies.of_other.clear();
  refined_.covariance = {};
  measureNoise({R, Eigen::Vector3d::UnitZ()}, refined_);
  fitRotation(refined_, alone_);
  judgement_.pose =
      publishRotation({R, Eigen::Vector3d::Zero()}, {alone_.R, rotationCovariance(refined_.model(), alone_.R), 0});
  return conclude(refined_, DirectionDoubt::kRotationExplains, true);
}

Verdict PoseJudge::compare(const RefinedPose& refined, const std::vector<AlternativeMotion>& alternatives,
                           bool shutter_may_roll) {
  Verdict verdict = compareRotations(refined, alone_, shutter_may_roll);
  if (verdict.rotationIsBetter()) return verdict;
  const auto camera_decides = [&] {
    return !directionIsKnown(covarianceOfAnyCamera(refined.information, refined.noise.variance()));
  };
  compareMotions(refined, directionSigma(refined.covariance.of_matches), camera_decides, alternatives, residuals_,
                 verdict);
  return verdict;
}

DirectionDoubt PoseJudge::doubt(const RefinedPose& refined, const Verdict& verdict) {
  const PoseSquare &own = refined.covariance.covariance, with_motions = own + verdict.spread;
  if (verdict.rotationExplains()) return DirectionDoubt::kRotationExplains;
  if (verdict.mostlyStatic()) return DirectionDoubt::kMostlyStatic;
  if (!rotationIsKnown(refined.covariance)) return DirectionDoubt::kRotation;
  if (!directionIsKnown(own)) return DirectionDoubt::kDirection;
  const bool torn = refined.worst_break.weaker_side * directionSigma(with_motions) > kKnownByItself;
  const bool other = verdict.other_motion || !directionIsKnown(with_motions) || torn || secondIsAsLarge(refined);
  return other ? DirectionDoubt::kOtherMotion : DirectionDoubt::kNone;
}

bool PoseJudge::directionIsKnown(const PoseSquare& covariance) const {
  return directionSigma(covariance) <= options_.max_direction_sigma * kDegree;
}

bool PoseJudge::secondIsAsLarge(const RefinedPose& refined) {
  const double most = refined.covariance.camera.statistic > 1 ? kMostOfSecondJoined : kMostOfSecond;
  return segmentation_.shareOfSecond(refined, most) > most;
}

const Judgement& PoseJudge::conclude(const RefinedPose& refined, DirectionDoubt doubt, bool rotated) {
  const TwoViewPoints& points = *refined.points;
  const MatchNoise& noise = refined.noise;
  const CameraTest& camera = refined.covariance.camera;
  judgement_.pose_found = true;
  judgement_.rotation_alone = alone_.R.transpose();
  judgement_.doubt = doubt;
  judgement_.translation_observable = doubt == DirectionDoubt::kNone;
  if (!judgement_.translation_observable) setTranslationVariance(kAnyDirection, judgement_.pose.covariance);
  judgement_.median_parallax_px = alone_.median_parallax * points.pixelsPerUnit();
  judgement_.camera_misfit = camera.statistic;
  judgement_.misfit_parameter = camera.parameter;
  judgement_.row_rates = camera.rates;
  judgement_.sigma_px = noise.sigma() * options_.inlierThreshold();
  judgement_.noise_exponent = points.noiseExponent();
  points.toRows(
      noise.weigh(points.view(), points.finestWeight(), refined.bodies.of_other, rotated ? &alone_.residuals : nullptr),
      judgement_.probability);
  points.toRows(rotated ? alone_.residuals : noise.residuals(), judgement_.residual);
  // A transfer distance has the noise of both images.
  noise.toDeviations(rotated ? 0.5 : 1, judgement_.residual);
  return judgement_;
}

}  // namespace gms_ransac
