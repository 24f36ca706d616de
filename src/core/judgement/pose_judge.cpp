#include "judgement/pose_judge.h"

namespace gms_ransac {

void PoseJudge::judge(const JudgedMatches& matches, const TwoViewPose& optimum, const TwoViewPose& pose,
                      const std::vector<AlternativeMotion>& alternatives, RobustResult& result) {
  const PoseModel model(*kernels_, matches.points);
  residuals_.resize(static_cast<size_t>(matches.points.size));
  model.residuals(optimum, residuals_.data());
  const RotationOnly rotation = fitRotation(matches, optimum, result);
  if (!(result.median_parallax_px > kObservableParallaxPx)) {
    result.pose = fromReferenceToCurrent(optimum.R, optimum.t);
    return settleForRotation(rotation, result);
  }
  double rotation_spread;
  alternative_buffers_.by_cell.reserve(static_cast<size_t>(kSpreadGridSide) * kSpreadGridSide);
  alternative_buffers_.residuals.resize(residuals_.size());
  result.ambiguous = findAlternativeMotion(*kernels_, matches.points, optimum, residuals_, alternatives, *matches.cells,
                                           alternative_buffers_, rotation_spread, result.effort.point_evaluations);
  result.translation_observable = !result.ambiguous;
  result.pose = fromReferenceToCurrent(pose.R, pose.t);
  result.pose.covariance = poseCovariance(model, matches.points.count, optimum);
  if (result.ambiguous) {
    result.pose.covariance.topLeftCorner<3, 3>() = rotation.covariance.topLeftCorner<3, 3>();
    result.pose.covariance.bottomRightCorner<3, 3>() += rotation_spread * rotation_spread * Eigen::Matrix3d::Identity();
  }
}

void PoseJudge::takeAsItIs(const JudgedMatches& matches, const TwoViewPose& optimum, const TwoViewPose& pose,
                           RobustResult& result) {
  const PoseModel model(*kernels_, matches.points);
  residuals_.resize(static_cast<size_t>(matches.points.size));
  model.residuals(optimum, residuals_.data());
  fitRotation(matches, optimum, result);
  result.ambiguous = false;
  result.translation_observable = true;
  result.pose = fromReferenceToCurrent(pose.R, pose.t);
  result.pose.covariance = poseCovariance(model, matches.points.count, optimum);
}

void PoseJudge::judgeRotation(const JudgedMatches& matches, const Eigen::Matrix3d& R, RobustResult& result) {
  residuals_.resize(static_cast<size_t>(matches.points.size));
  PoseModel(*kernels_, matches.points).rotationResiduals(R, residuals_.data());
  const RotationOnly rotation = fitRotation(matches, {R, Eigen::Vector3d::Zero()}, result);
  result.pose = fromReferenceToCurrent(R, Eigen::Vector3d::Zero());
  settleForRotation(rotation, result);
}

RotationOnly PoseJudge::fitRotation(const JudgedMatches& matches, const TwoViewPose& start, RobustResult& result) {
  rotation_residuals_.resize(residuals_.size());
  const PoseModel model(*kernels_, matches.points);
  RotationOnly rotation =
      fitRotationOnly(model, matches.points, start, residuals_, rotation_residuals_, result.effort.point_evaluations);
  result.pose_found = true;
  result.median_parallax_px = rotation.median_residual * matches.unit_px;
  return rotation;
}

void PoseJudge::settleForRotation(const RotationOnly& rotation, RobustResult& result) {
  result.translation_observable = result.ambiguous = false;
  result.pose.R = rotation.R.transpose();
  result.pose.covariance = rotation.covariance;
}

}  // namespace gms_ransac
