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
    : kernels_(residualKernels(options.simd)), options_(options), other_motions_(kernels_) {}

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
  spread_ = poseCovariance(information_, noise_.sigma(), options_.calibration_sigma);
  if (options_.judge) break_ = findBreak(information_, noise_.sigma() * noise_.sigma());
}

bool PoseJudge::atOptimum(int count) const {
  const Loss loss = noise_.loss();
  if (loss.inverse_softness != 1) return false;
  for (int i = 0; i < count; ++i) {
    if (!noise_.plausible(i) && noise_.residuals()[static_cast<size_t>(i)] < loss.cut) return false;
  }
  return true;
}

const RotationOnly& PoseJudge::fitRotation(const TwoViewPoints& points) {
  const RotationOnly& rotation = rotation_explanation_.fit(kernels_, points.view(), pose_, noise_);
  judgement_.pose_found = true;
  judgement_.median_parallax_px = rotation.median_parallax * points.pixelsPerUnit();
  judgement_.camera_misfit = spread_.camera.statistic;
  judgement_.misfit_parameter = spread_.camera.parameter;
  return rotation;
}

const Judgement& PoseJudge::judge(const TwoViewPoints& points, const TwoViewPose& preferred,
                                  const std::vector<AlternativeMotion>& alternatives) {
  const RotationOnly& rotation = fitRotation(points);
  judgement_.doubt = DirectionDoubt::kNone;
  PoseSquare covariance = spread_.covariance;
  RotationVerdict verdict;
  if (options_.judge) {
    verdict = rotation_explanation_.compare(points, pose_, noise_);
    judgement_.doubt = compare(points, verdict, alternatives, covariance);
  }
  judgement_.translation_observable = judgement_.doubt == DirectionDoubt::kNone;
  if (options_.judge && verdict.rotationIsBetter()) {
    // Both explanations are possible, so the covariance is inflated by the disagreement of the two rotations.
    const Eigen::Vector3d apart = rotationVector(rotation.R * pose_.R.transpose());
    covariance.topLeftCorner<3, 3>() += apart * apart.transpose();
    pose_.R = rotation.R;
    judgement_.pose = publish(pose_, covariance);
  } else {
    judgement_.pose = publish(preferred, covariance);
  }
  if (!judgement_.translation_observable) setTranslationVariance(kAnyDirection, judgement_.pose.covariance);
  weighMatches(points, options_.judge && verdict.onlyRotated() ? &rotation.residuals : nullptr);
  return judgement_;
}

const Judgement& PoseJudge::judgeRotation(const TwoViewPoints& points, const Eigen::Matrix3d& R) {
  segmentation_.apart.clear();
  spread_ = {};
  measureNoise(points.view(), {R, Eigen::Vector3d::UnitZ()});
  const RotationOnly& rotation = fitRotation(points);
  judgement_.doubt = DirectionDoubt::kRotationExplains;
  judgement_.translation_observable = false;
  judgement_.pose = fromReferenceToCurrent(rotation.R, Eigen::Vector3d::Zero());
  judgement_.pose.covariance.bottomRightCorner<3, 3>() = rotation_explanation_.covariance(kernels_, points.view());
  setTranslationVariance(kAnyDirection, judgement_.pose.covariance);
  weighMatches(points, &rotation.residuals);
  return judgement_;
}

DirectionDoubt PoseJudge::compare(const TwoViewPoints& points, const RotationVerdict& verdict,
                                  const std::vector<AlternativeMotion>& alternatives, PoseSquare& covariance) {
  DirectionDoubt doubt = verdict.doubt();
  const PoseSquare& of_rotation = spread_.camera.statistic < kBeyondCameras ? spread_.of_matches : spread_.covariance;
  const bool rotation_is_known = of_rotation.topLeftCorner<3, 3>().trace() <= kMostRotationSigma * kMostRotationSigma;
  if (doubt == DirectionDoubt::kNone && !rotation_is_known) doubt = DirectionDoubt::kRotation;
  if (doubt == DirectionDoubt::kNone && !directionIsKnown(directionSigma(covariance))) {
    doubt = DirectionDoubt::kDirection;
  }
  if (verdict.rotationIsBetter()) return doubt;
  // A motion whose direction is not known may still be the wrong one of two, with another rotation.
  const bool camera_decides = !directionIsKnown(spread_.direction_sigma_any_camera);
  const Ambiguity ambiguity = other_motions_.compare({pose_, points, plausible_.view(), noise_},
                                                     directionSigma(spread_.of_matches), camera_decides, alternatives);
  covariance += ambiguity.covariance;
  if (doubt != DirectionDoubt::kNone) return doubt;
  const double direction_sigma = directionSigma(covariance);
  if (ambiguity.other_direction || !directionIsKnown(direction_sigma)) return DirectionDoubt::kOtherMotion;
  if (break_.weaker_side * direction_sigma > kKnownByItself) return DirectionDoubt::kOtherMotion;
  const double most = spread_.camera.statistic > 1 ? kMostOfSecondJoined : kMostOfSecond;
  const bool second = (segmentation_.found() && segmentation_.smaller_share > most) ||
                      other_motions_.shareOfSecond(points.view(), noise_, most) > most;
  return second ? DirectionDoubt::kOtherMotion : DirectionDoubt::kNone;
}

bool PoseJudge::directionIsKnown(double direction_sigma) const {
  return direction_sigma <= options_.max_direction_sigma * kDegree;
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

void PoseJudge::weighMatches(const TwoViewPoints& points, const std::vector<float>* rotation_residuals) {
  judgement_.sigma_px = noise_.sigma() * options_.inlierThreshold();
  judgement_.noise_exponent = points.noiseExponent();
  const PointColumnsView view = points.view();
  const float finest = points.finestWeight();
  points.inOrderOfMatches(rotation_residuals != nullptr
                              ? probability_.weighRotated(noise_, *rotation_residuals, view, finest)
                              : probability_.weigh(noise_, segmentation_.apart, view, finest),
                          judgement_.probability);
  points.inOrderOfMatches(rotation_residuals != nullptr ? *rotation_residuals : noise_.residuals(),
                          judgement_.residual);
  // A transfer distance has the noise of both images.
  noise_.toDeviations(rotation_residuals != nullptr ? 0.5 : 1, judgement_.residual);
}

}  // namespace gms_ransac
