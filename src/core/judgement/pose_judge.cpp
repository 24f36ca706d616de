#include "judgement/pose_judge.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace gms_ransac {

namespace {

/// Of the three axes together: a rotation that is known worse is of no use, whatever the direction.
constexpr double kMostRotationSigma = M_PI / 180;
/// From such a contradiction on what the camera model leaves out is more than what cameras in use are off by: the pose
/// must be known even so.
constexpr double kBeyondCameras = 10;
constexpr int kIterations = 10;
/// Squared Mahalanobis distance by degree of freedom at which a preference is followed half way.
constexpr double kHalfWay = 4;

void leaveDirectionOpen(Eigen::Matrix<double, 6, 6>& covariance) {
  const Eigen::Matrix3d rotation = covariance.bottomRightCorner<3, 3>();
  covariance.setZero();
  covariance.topLeftCorner<3, 3>() = anyDirection();
  covariance.bottomRightCorner<3, 3>() = rotation;
}

}  // namespace

void PoseJudge::begin(const TwoViewPoints& points) {
  points_ = &points;
  view_ = points.view();
  plausible_.resize(view_.count);  // whether or not it is needed, so that a later pair allocates nothing
  measured_ = false;
  bodies_.begin();
  noise_.forgetApart();
}

void PoseJudge::measureNoise(const TwoViewPose& pose, Effort& effort) {
  if (measured_ && pose.R == measured_at_.R && pose.t == measured_at_.t) return;
  noise_.measure(PoseModel(kernels_, view_), view_, pose, effort.point_evaluations);
  measured_ = true;
  spread_known_ = false;
  measured_at_ = pose;
}

void PoseJudge::refine(TwoViewPose& pose, Effort& effort) {
  followNoise(pose, effort);
  if (options_.judge) followLargerBody(pose, effort);
}

void PoseJudge::followLargerBody(TwoViewPose& pose, Effort& effort) {
  if (!measuredSpread().pose_break.found()) return;
  bodies_.part(judged(), effort.point_evaluations);
  if (!bodies_.found()) return;
  pose = bodies_.larger();
  noise_.setApart(bodies_.apart());
  measured_ = false;
  followNoise(pose, effort);
}

void PoseJudge::followNoise(TwoViewPose& pose, Effort& effort) {
  measureNoise(pose, effort);
  const Loss loss = noise_.loss();
  if (loss.inverse_softness == 1 && !weighsImplausible(loss.cut)) return;  // it is at the optimum
  keepPlausible();
  const int passes = PoseModel(kernels_, plausible_.view()).refine(loss, kIterations, pose, kEnough);
  effort.point_evaluations += static_cast<int64_t>(view_.count) * passes;
  measureNoise(pose, effort);
}

bool PoseJudge::weighsImplausible(float cut) const {
  for (int i = 0; i < view_.count; ++i) {
    if (noise_.residuals()[static_cast<size_t>(i)] < cut && !noise_.plausible(i)) return true;
  }
  return false;
}

void PoseJudge::keepPlausible() {
  std::copy_n(view_.x1, view_.count, plausible_.x1());
  std::copy_n(view_.y1, view_.count, plausible_.y1());
  std::copy_n(view_.x2, view_.count, plausible_.x2());
  std::copy_n(view_.y2, view_.count, plausible_.y2());
  for (int i = 0; i < view_.count; ++i) plausible_.weight()[i] = noise_.plausible(i) ? view_.weight[i] : 0;
}

void PoseJudge::judge(const TwoViewPose& optimum, const TwoViewPose& preferred,
                      const std::vector<AlternativeMotion>& alternatives, RobustResult& result) {
  int64_t& evaluations = result.effort.point_evaluations;
  measureNoise(optimum, result.effort);
  const RotationOnly rotation = fitRotation(optimum, result);
  PoseSpread spread = describeSpread(result);
  const RotationVerdict verdict = rivals_.compare(judged(), rotation.R, rotation_residuals_);
  const bool turn_alone = verdict.believed() == BelievedRotation::kOfTurn;
  result.doubt = doubtOf(verdict, spread);
  // A motion whose direction is not known may still be the wrong one of two, with another rotation.
  const bool other_direction = !turn_alone && takeInAlternatives(alternatives, spread, result.effort);
  if (result.doubt == DirectionDoubt::kNone &&
      (other_direction || !closeEnough(spread) || second_body_.isRival(judged(), bodies_, evaluations))) {
    result.doubt = DirectionDoubt::kOtherMotion;
  }
  result.translation_observable = result.doubt == DirectionDoubt::kNone;

  if (verdict.believed() != BelievedRotation::kOfPose) {
    // With and without a translation are both in question, so the rotation is no better known than they agree.
    const Eigen::Vector3d apart = rotationVector(rotation.R * optimum.R.transpose());
    spread.covariance.topLeftCorner<3, 3>() += apart * apart.transpose();
  }
  if (turn_alone) {
    const TwoViewPose turn = {rotation.R, optimum.t};
    settle(turn, turn, spread, result);
  } else {
    settle(optimum, preferred, spread, result);
  }
  if (!result.translation_observable) leaveDirectionOpen(result.pose.covariance);
  describeMatches(verdict.onlyTurned(), result);
}

const PoseSpread& PoseJudge::measuredSpread() {
  if (!spread_known_) {
    spread_ = uncertainty_.measure(view_, measured_at_, noise_, points_->cells(), options_.calibration_sigma);
  }
  spread_known_ = true;
  return spread_;
}

PoseSpread PoseJudge::describeSpread(RobustResult& result) {
  const PoseSpread& spread = measuredSpread();
  result.camera_misfit = spread.contradiction;
  result.misfit_parameter = spread.contradicted;
  result.camera_errors = spread.camera_errors;
  return spread;
}

bool PoseJudge::takeInAlternatives(const std::vector<AlternativeMotion>& alternatives, PoseSpread& spread,
                                   Effort& effort) {
  keepPlausible();
  const Ambiguity ambiguity =
      other_motions_.compare(judged(), plausible_.view(), alternatives, effort.point_evaluations);
  spread.covariance += ambiguity.covariance;
  return ambiguity.other_direction;
}

DirectionDoubt PoseJudge::doubtOf(const RotationVerdict& verdict, const PoseSpread& spread) const {
  if (verdict.doubt() != DirectionDoubt::kNone) return verdict.doubt();
  if (!knowsRotation(spread)) return DirectionDoubt::kRotation;
  return closeEnough(spread) ? DirectionDoubt::kNone : DirectionDoubt::kDirection;
}

bool PoseJudge::knowsRotation(const PoseSpread& spread) {
  const auto& covariance = spread.contradiction < kBeyondCameras ? spread.of_matches : spread.covariance;
  return covariance.topLeftCorner<3, 3>().trace() <= kMostRotationSigma * kMostRotationSigma;
}

bool PoseJudge::closeEnough(const PoseSpread& spread) const {
  return directionSigma(spread.covariance) <= options_.max_direction_sigma * M_PI / 180;
}

void PoseJudge::takeAsItIs(const TwoViewPose& optimum, const TwoViewPose& preferred, RobustResult& result) {
  measureNoise(optimum, result.effort);
  fitRotation(optimum, result);
  PoseSpread spread = describeSpread(result);
  result.doubt = DirectionDoubt::kNone;
  result.translation_observable = true;
  settle(optimum, preferred, spread, result);
  describeMatches(false, result);
}

void PoseJudge::judgeRotation(const Eigen::Matrix3d& R, RobustResult& result) {
  const TwoViewPose pose = {R, Eigen::Vector3d::UnitZ()};
  measureNoise(pose, result.effort);
  const RotationOnly rotation = fitRotation(pose, result);
  result.doubt = DirectionDoubt::kTurn;
  result.translation_observable = false;
  result.pose = fromReferenceToCurrent(rotation.R, Eigen::Vector3d::Zero());
  result.pose.covariance = rotation.covariance;
  describeMatches(true, result);
}

RotationOnly PoseJudge::fitRotation(const TwoViewPose& start, RobustResult& result) {
  rotation_residuals_.resize(noise_.residuals().size());
  RotationOnly rotation = fitRotationOnly(PoseModel(kernels_, view_), view_, start, noise_.residuals(), noise_.sigma(),
                                          rotation_residuals_, sorted_, result.effort.point_evaluations);
  result.pose_found = true;
  result.median_parallax_px = rotation.median_residual * points_->pixelsPerUnit();
  return rotation;
}

void PoseJudge::settle(const TwoViewPose& optimum, const TwoViewPose& preferred, PoseSpread& spread,
                       RobustResult& result) const {
  // The reason for the preferred rotation is a guess about the scene, which a clear optimum overrules: it is followed
  // the less the further it is from the optimum in terms of the optimum's own covariance, whatever other motions there
  // are. How far that goes may all be error.
  auto rotation = spread.covariance.topLeftCorner<3, 3>();
  Eigen::Vector3d step = rotationVector(preferred.R * optimum.R.transpose());
  if (bodies_.found()) step.setZero();  // the preference is that of both
  const Eigen::Matrix3d own = spread.sandwich.topLeftCorner<3, 3>();
  const double distance = step.dot(own.ldlt().solve(step)) / 3;
  step = std::isfinite(distance) ? Eigen::Vector3d(step / (1 + distance / kHalfWay)) : Eigen::Vector3d::Zero();
  rotation += step * step.transpose();
  const Eigen::Matrix3d R = rotationFromVector(step) * optimum.R;
  // The direction in the reference camera stays that of the optimum.
  result.pose = fromReferenceToCurrent(R, R * optimum.R.transpose() * optimum.t);
  result.pose.covariance = relativeCovariance(optimum, spread.covariance);
}

void PoseJudge::describeMatches(bool turned, RobustResult& result) {
  result.sigma_px = noise_.sigma() * options_.inlierThreshold();
  const float finest = points_->finestWeight();
  points_->inOrderOfMatches(turned ? probability_.weighTurned(noise_, rotation_residuals_, view_, finest)
                                   : probability_.weigh(noise_, view_, finest),
                            result.probability);
}

}  // namespace gms_ransac
