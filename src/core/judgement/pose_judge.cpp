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

}  // namespace

PoseJudge::PoseJudge(const RobustOptions& options)
    : kernels_(residualKernels(options.simd)), options_(options), noise_(kernels_), candidates_(kernels_) {}

void PoseJudge::refine(const TwoViewPoints& points, bool move, TwoViewPose& pose) {
  segmentation_.apart.clear();
  measure(points, move, pose);
  if (!move || !options_.judge) return;
  segmentation_.find(kernels_, points, pose, noise_, break_);
  if (!segmentation_.found()) return;
  pose = segmentation_.larger;
  measure(points, true, pose);
}

void PoseJudge::measureNoise(const PointColumnsView& points, const TwoViewPose& pose) {
  pose_ = pose;
  noise_.measure(PoseModel(kernels_, points), pose, segmentation_.apart);
  plausible_.copy(points, [this](int column) { return noise_.plausible(column); });
}

void PoseJudge::measure(const TwoViewPoints& points, bool move, TwoViewPose& pose) {
  measureNoise(points.view(), pose);
  if (move && !atOptimum(points.size())) {
    PoseModel(kernels_, plausible_.view()).refine(noise_.loss(), kFinalIterations, pose, kEnough);
    measureNoise(points.view(), pose);
  }
  information_.sum(kernels_, plausible_.view(), pose_, noise_.loss(), points.cells());
  spread_ = poseCovariance(information_, noise_.variance(), options_.calibration_sigma);
  if (options_.judge) break_ = findBreak(information_, noise_.variance());
}

bool PoseJudge::atOptimum(int count) const {
  const Loss loss = noise_.loss();
  if (loss.inverse_softness != 1) return false;
  for (int i = 0; i < count; ++i) {
    if (!noise_.plausible(i) && noise_.residuals()[static_cast<size_t>(i)] < loss.cut) return false;
  }
  return true;
}

const Judgement& PoseJudge::judge(const TwoViewPoints& points, const TwoViewPose& preferred,
                                  const std::vector<AlternativeMotion>& alternatives, bool shutter_may_roll) {
  candidates_.fitRotation(points.view(), pose_.R, noise_);
  const RefinedPose refined = {pose_, points, plausible_.view(), noise_};
  PoseSquare covariance = spread_.covariance;
  DirectionDoubt doubt = DirectionDoubt::kNone;
  if (options_.judge) {
    candidates_.compareRotations(refined, shutter_may_roll);
    if (!candidates_.rotationIsBetter()) {
      candidates_.compareMotions(
          refined, directionSigma(spread_.of_matches), [this] { return cameraDecides(); }, alternatives);
    }
    covariance += candidates_.spread;
    doubt = verdict(points, directionSigma(covariance));
  }
  judgement_.pose =
      doubt == DirectionDoubt::kNone
          ? publish(preferred, covariance)
          : publishRotation(candidates_.rotationWithoutTranslation(refined, covariance.topLeftCorner<3, 3>()));
  return conclude(points, doubt, candidates_.onlyRotated());
}

const Judgement& PoseJudge::judgeRotation(const TwoViewPoints& points, const Eigen::Matrix3d& R) {
  segmentation_.apart.clear();
  spread_ = {};
  measureNoise(points.view(), {R, Eigen::Vector3d::UnitZ()});
  candidates_.fitRotation(points.view(), R, noise_);
  pose_.t.setZero();
  judgement_.pose = publishRotation({candidates_.rotation, candidates_.rotationCovariance(points.view()), 0});
  return conclude(points, DirectionDoubt::kRotationExplains, true);
}

DirectionDoubt PoseJudge::verdict(const TwoViewPoints& points, double direction_sigma) {
  if (candidates_.raise(DirectionDoubt::kRotationExplains)) return DirectionDoubt::kRotationExplains;
  if (candidates_.mostlyStatic()) return DirectionDoubt::kMostlyStatic;
  if (!rotationIsKnown()) return DirectionDoubt::kRotation;
  if (!directionIsKnown(directionSigma(spread_.covariance))) return DirectionDoubt::kDirection;
  const bool torn = break_.weaker_side * direction_sigma > kKnownByItself;
  const bool other = candidates_.raise(DirectionDoubt::kOtherMotion) || !directionIsKnown(direction_sigma) || torn ||
                     secondIsAsLarge(points.view());
  return other ? DirectionDoubt::kOtherMotion : DirectionDoubt::kNone;
}

bool PoseJudge::rotationIsKnown() const {
  const PoseSquare& covariance = spread_.camera.statistic < kBeyondCameras ? spread_.of_matches : spread_.covariance;
  return covariance.topLeftCorner<3, 3>().trace() <= kMostRotationSigma * kMostRotationSigma;
}

bool PoseJudge::directionIsKnown(double direction_sigma) const {
  return direction_sigma <= options_.max_direction_sigma * kDegree;
}

bool PoseJudge::cameraDecides() const {
  return !directionIsKnown(directionSigma(covarianceOfAnyCamera(information_, noise_.variance())));
}

bool PoseJudge::secondIsAsLarge(const PointColumnsView& points) {
  const double most = spread_.camera.statistic > 1 ? kMostOfSecondJoined : kMostOfSecond;
  return segmentation_.shareOfSecond(kernels_, points, noise_, most) > most;
}

RelativePose PoseJudge::publish(const TwoViewPose& preferred, PoseSquare covariance) const {
  // The reason for the preferred rotation is a guess about the scene, which a clear optimum overrules: it is followed
  // the less the further it is from the optimum in terms of the optimum's own covariance. How far that goes may all be
  // error.
  Eigen::Vector3d step = rotationVector(preferred.R * pose_.R.transpose());
  if (segmentation_.found()) step.setZero();  // the preference is that of both bodies
  const Eigen::Matrix3d own = spread_.naive.topLeftCorner<3, 3>();
  const double distance = step.dot(own.llt().solve(step)) / 3;
  step = std::isfinite(distance) ? Eigen::Vector3d(step / (1 + distance / kHalfWay)) : Eigen::Vector3d::Zero();
  covariance.topLeftCorner<3, 3>() += step * step.transpose();
  const Eigen::Matrix3d R = rotationFromVector(step) * pose_.R;
  // The direction in the reference camera stays that of the optimum.
  RelativePose pose = fromReferenceToCurrent(R, R * pose_.R.transpose() * pose_.t);
  pose.covariance = relativeCovariance(pose_, covariance);
  return pose;
}

RelativePose PoseJudge::publishRotation(const Explanation& explanation) const {
  const Eigen::Matrix3d& R = explanation.R;
  // The direction in the reference camera, a guess, stays that of the optimum.
  RelativePose pose = fromReferenceToCurrent(R, R * pose_.R.transpose() * pose_.t);
  pose.covariance.bottomRightCorner<3, 3>() = R.transpose() * explanation.covariance * R;
  return pose;
}

const Judgement& PoseJudge::conclude(const TwoViewPoints& points, DirectionDoubt doubt, bool rotated) {
  judgement_.pose_found = true;
  judgement_.rotation_alone = candidates_.rotation.transpose();
  judgement_.doubt = doubt;
  judgement_.translation_observable = doubt == DirectionDoubt::kNone;
  if (!judgement_.translation_observable) setTranslationVariance(kAnyDirection, judgement_.pose.covariance);
  judgement_.median_parallax_px = candidates_.median_parallax * points.pixelsPerUnit();
  judgement_.camera_misfit = spread_.camera.statistic;
  judgement_.misfit_parameter = spread_.camera.parameter;
  judgement_.row_rates = spread_.camera.rates;
  judgement_.sigma_px = noise_.sigma() * options_.inlierThreshold();
  judgement_.noise_exponent = points.noiseExponent();
  const std::vector<float>& residuals = rotated ? candidates_.rotation_residuals : noise_.residuals();
  points.inOrderOfMatches(noise_.weigh(points.view(), points.finestWeight(), segmentation_.apart,
                                       rotated ? &candidates_.rotation_residuals : nullptr),
                          judgement_.probability);
  points.inOrderOfMatches(residuals, judgement_.residual);
  // A transfer distance has the noise of both images.
  noise_.toDeviations(rotated ? 0.5 : 1, judgement_.residual);
  return judgement_;
}

}  // namespace gms_ransac
