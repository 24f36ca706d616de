#include "judgement/pose_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "judgement/probability.h"

namespace gms_ransac {

namespace {

constexpr double kDegree = M_PI / 180;

/// Measures the noise at a pose.
void measureNoise(const TwoViewPose& pose, RefinedPose& refined) {
  refined.pose = pose;
  refined.noise.measure(refined.model(), pose, refined.bodies.of_other);
  refined.plausible.copy(refined.points->view(), [&](int slot) { return refined.noise.plausible(slot); });
}

/// Noise and covariance at a pose or, with `move`, at the optimum of the loss that the noise asks for.
void measure(const RobustOptions& options, bool move, TwoViewPose pose, RefinedPose& refined) {
  measureNoise(pose, refined);
  if (move) {
    refined.plausibleModel().refine(refined.noise.loss(), kFinalIterations, pose, kEnough);
    measureNoise(pose, refined);
  }
  const double variance = refined.noise.variance();
  refined.information.sum(refined.kernels, refined.plausible.view(), pose, refined.noise.loss(),
                          refined.points->cells());
  refined.covariance = poseCovariance(refined.information, variance, options.calibration_sigma);
  if (options.judge) refined.worst_break = findBreak(refined.information, variance);
}

RelativePose publish(const TwoViewPose& pose, const PoseSquare& covariance) {
  RelativePose published = fromReferenceToCurrent(pose.R, pose.t);
  published.covariance = relativeCovariance(pose, covariance);
  return published;
}

/// The pose of a rotation whose translation is a guess: in the reference camera its direction stays that of `optimum`.
RelativePose publishRotation(const TwoViewPose& optimum, const Explanation& explanation) {
  const Eigen::Matrix3d& R = explanation.R;
  RelativePose pose = fromReferenceToCurrent(R, R * optimum.R.transpose() * optimum.t);
  pose.covariance.bottomRightCorner<3, 3>() = R.transpose() * explanation.covariance * R;
  return pose;
}

double shareOfInliers(const MatchNoise& noise, int count) {
  const auto end = noise.residuals().begin() + count;
  return static_cast<double>(std::count_if(noise.residuals().begin(), end, [](float e) { return e < 1; })) / count;
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

const Judgement& PoseJudge::judge(const RefinedPose& refined, const std::vector<AlternativeMotion>& alternatives,
                                  bool shutter_may_roll) {
  fitRotation(refined, alone_);
  const Verdict verdict = options_.judge ? compare(refined, alternatives, shutter_may_roll) : Verdict();
  judgement_.motion = publish(refined.pose, refined.covariance.covariance + verdict.spread);
  if (options_.judge) {
    judgement_.evidence = evidenceOf(refined, verdict);
    judgement_.rotation = judgement_.motion;
    decide(options_, judgement_);
    if (!judgement_.translation_observable) {
      judgement_.rotation = publishRotation(refined.pose, rotationWithoutTranslation(refined, alone_, verdict));
      decide(options_, judgement_);
    }
  } else {
    accept(true);
  }
  return conclude(refined, verdict.onlyRotated());
}

const Judgement& PoseJudge::judgeRotation(const TwoViewPoints& points, const Eigen::Matrix3d& R) {
  refined_.points = &points;
  refined_.bodies.of_other.clear();
  refined_.covariance = {};
  measureNoise({R, Eigen::Vector3d::UnitZ()}, refined_);
  fitRotation(refined_, alone_);
  judgement_.rotation =
      publishRotation({R, Eigen::Vector3d::Zero()}, {alone_.R, rotationCovariance(refined_.model(), alone_.R), 0});
  judgement_.motion = judgement_.rotation;
  accept(false);
  if (options_.judge) {
    judgement_.evidence[Evidence::kRotation] = -std::numeric_limits<double>::infinity();
    judgement_.evidence[Evidence::kInlierShare] = shareOfInliers(refined_.noise, points.size());
    decide(options_, judgement_);
  }
  return conclude(refined_, true);
}

void PoseJudge::accept(bool with_translation) {
  judgement_.evidence = EvidenceTable();
  judgement_.pose_probability = judgement_.rotation_probability = 0;
  judgement_.translation_observable = with_translation;
  judgement_.rotation_observable = true;
  judgement_.doubt = with_translation ? DirectionDoubt::kNone : DirectionDoubt::kRotationExplains;
  judgement_.pose = judgement_.rotation = judgement_.motion;
}

Verdict PoseJudge::compare(const RefinedPose& refined, const std::vector<AlternativeMotion>& alternatives,
                           bool shutter_may_roll) {
  Verdict verdict = compareRotations(refined, alone_, shutter_may_roll);
  if (verdict.rotationIsBetter()) return verdict;
  compareMotions(refined, directionSigma(refined.covariance.of_matches), alternatives, residuals_, verdict);
  return verdict;
}

EvidenceTable PoseJudge::evidenceOf(const RefinedPose& refined, const Verdict& verdict) {
  const double direction_sigma = directionSigma(refined.covariance.covariance + verdict.spread) / kDegree;
  EvidenceTable evidence;
  evidence[Evidence::kRotation] = std::min(verdict.rotation, verdict.rolling);
  evidence[Evidence::kStatic] = verdict.static_share;
  evidence[Evidence::kInfinity] = verdict.share_at_infinity;
  evidence[Evidence::kRotationSigma] = std::sqrt(refined.covariance.of_matches.topLeftCorner<3, 3>().trace()) / kDegree;
  evidence[Evidence::kDirectionSigma] = direction_sigma / options_.max_direction_sigma;
  evidence[Evidence::kOtherMotion] = verdict.other_motion;
  if (refined.bodies.found()) evidence[Evidence::kSecondBody] = refined.bodies.smaller_share;
  evidence[Evidence::kTorn] = refined.worst_break.weaker_side * direction_sigma;
  evidence[Evidence::kInlierShare] = shareOfInliers(refined.noise, refined.points->size());
  return evidence;
}

const Judgement& PoseJudge::conclude(const RefinedPose& refined, bool rotated) {
  const TwoViewPoints& points = *refined.points;
  const MatchNoise& noise = refined.noise;
  const CameraTest& camera = refined.covariance.camera;
  judgement_.pose_found = true;
  judgement_.rotation_alone = alone_.R.transpose();
  judgement_.median_parallax_px = alone_.median_parallax * points.pixelsPerUnit();
  judgement_.camera_misfit = camera.statistic;
  judgement_.misfit_parameter = camera.parameter;
  judgement_.row_rates = camera.rates;
  judgement_.sigma_px = noise.sigma() * options_.inlierThreshold();
  judgement_.aligned_sigma_px = judgement_.sigma_px * points.alignedSigma();
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
