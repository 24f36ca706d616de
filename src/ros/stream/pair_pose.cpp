#include "stream/pair_pose.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "stream/processed_frame.h"
#include "stream/stream.h"

namespace gms_ransac {

namespace {

/// In units of the first pair's.
void propagate(ScalePropagator& scale, ProcessedFrame& answer) {
  if (answer.status != MatchStats::OK) return scale.carryThroughRotation(answer.pair->points, answer.pair->result);
  const Camera& camera = answer.current->image.camera->camera;
  const ScaleEstimate length = scale.update(answer.pair->points, answer.pair->result, camera, answer.recovered);
  answer.pose = withLength(answer.pose, length);
  answer.length_missing &= length.features == 0;
}

/// Length from odometry or the ground, or why there is none.
void measureBySensor(const MotionPriors& priors, ProcessedFrame& answer) {
  const PreparedFrame &reference = *answer.pair->reference, &current = *answer.current;
  if (current.image.stamp_verdict == StampVerdict::kAfterLate) {
    return answer.reasons.push_back(
        {Why::kNoLength, "an image before this one was late, so the time between is unsure"});
  }
  const PairSeen pair = {answer.pair->result.robust,
                         answer.pair->points,
                         current.image.camera->camera,
                         {reference.image.grey, current.image.grey}};
  const LengthAnswer measured = priors.length()->ask(priors.query(reference.image.header, current.image.header), pair);
  answer.metric_scale = measured.length.features > 0 && answer.status == MatchStats::OK;
  if (answer.metric_scale) answer.pose = withLength(answer.pose, measured.length);
  if (!measured.problem.empty()) answer.reasons.push_back({Why::kNoLength, measured.problem});
}

/// Metric pose from depth or a second camera, or why there is none.
void measureByDepth(bool stereo, Stream& stream, ProcessedFrame& answer) {
  const PreparedFrame &reference = *answer.pair->reference, &current = *answer.current;
  const std::optional<StereoRig>& rig = current.stereo.rig ? current.stereo.rig : reference.stereo.rig;
  DepthEstimate scale;
  if (rig || !stereo) {
    stream.useCameras({current.image.camera, current.stereo.right_camera});
    scale = poseFromKeypointDepth(
        {answer.pair->points, reference.frame.features, current.frame.features, answer.pair->result,
         current.image.camera->camera, reference.stereo.depth, current.stereo.depth, rig ? rig->baseline : 0,
         answer.pair->track_ids, reference.image.grey, current.image.grey},
        answer.pose, &stream.key, stereo ? static_cast<LearntSensor*>(&stream.rig) : &stream.offset);
  }
  answer.shared.rightCols<kSensorErrors>() = scale.by_sensor;
  if (rig) answer.rig = stream.rig;
  if (!stereo) answer.offset = stream.offset;
  answer.metric_scale = scale.features > 0;
  if (answer.metric_scale) answer.since_key = MotionSinceKey{stream.key.current, stream.key.is_reference};
  if (answer.metric_scale && answer.status != MatchStats::OK) {
    // Depth makes a translation observable that the images alone do not show.
    answer.status = MatchStats::OK;
    answer.reasons.push_back({Why::kMeasured, stereo ? "two cameras" : "depth image"});
  }
  if (answer.metric_scale) return;
  const std::string& problem = current.depth_problem.empty() ? reference.depth_problem : current.depth_problem;
  answer.reasons.push_back({Why::kNoLength, problem.empty() ? "too few inliers have depth" : problem});
}

/// By ~scale.
void findLength(const Pipeline& pipeline, Stream& stream, ProcessedFrame& answer) {
  const Parameters& parameters = pipeline.parameters;
  const ScaleMode mode = parameters.scale;
  if (mode == ScaleMode::kFixed && answer.status == MatchStats::OK && !answer.recovered) {
    answer.pose = withLength(answer.pose, {parameters.fixed_scale, 0, 1});
    answer.metric_scale = true;
  } else if (mode == ScaleMode::kPropagate) {
    propagate(stream.scale, answer);
  } else if (pipeline.priors && (mode == ScaleMode::kOdometry || mode == ScaleMode::kGround)) {
    measureBySensor(*pipeline.priors, answer);
  } else if (parameters.measuresDepth()) {
    measureByDepth(parameters.input == InputKind::kStereo, stream, answer);
  }
  answer.length_missing &= !answer.metric_scale;
}

// Largest entry of R^T R - 1. Estimators leave rounding errors; a quaternion would hide larger ones.
constexpr double kRotationTolerance = 1e-9;
// Tolerance of mirrored entries, in standard deviations of both: after the inversion of an ill-conditioned matrix, and
// for publishing.
constexpr double kInversionTolerance = 1e-3;
constexpr double kSymmetryTolerance = 1e-9;

bool isRotation(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRotationTolerance &&
         R.determinant() > 0;
}

bool isSymmetric(const Covariance6d& covariance, double tolerance) {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < i; ++j) {
      const double unit = std::sqrt(std::abs(covariance(i, i) * covariance(j, j)));
      if (std::abs(covariance(i, j) - covariance(j, i)) > tolerance * unit) return false;
    }
  }
  return true;
}

/// Bounds a covariance. An invalid one stays as it is: bounded, it would look valid.
void boundIfValid(Covariance6d& covariance) {
  if (covariance.allFinite() && covariance.diagonal().minCoeff() >= 0 && isSymmetric(covariance, kInversionTolerance)) {
    boundCovariance(covariance);
  }
}

/// Shared errors of a depth camera, in those of two cameras: Kinects have depths that are wrong by a per cent, of
/// another moment than the colour image, whose rows are of different moments as well (TUM freiburg1).
constexpr double kOfDepthImages = 3;

/// Widens the covariance of the pose, and keeps both parts of it. Images without depth tell the direction alone: what
/// measured the length does not share their errors.
void addSharedErrors(double systematic_sigma, const Parameters& parameters, ProcessedFrame& answer) {
  const double share = systematic_sigma * (parameters.scale == ScaleMode::kDepth ? kOfDepthImages : 1);
  const double parallax =
      answer.pair->result.robust.judgement.median_parallax_px / answer.current->image.camera->camera.meanFocalLength();
  answer.own_covariance = answer.pose.covariance;
  answer.shared += sharedErrors(share, answer.pose, parallax);
  if (!parameters.measuresDepth() && !answer.pose.t.isZero()) {
    const Eigen::Vector3d along = answer.pose.t.normalized();
    auto by_rotation = answer.shared.block<3, 4>(0, 4);
    by_rotation -= along * (along.transpose() * by_rotation).eval();
  }
  answer.pose.covariance += answer.shared * answer.shared.transpose();
  boundIfValid(answer.pose.covariance);
}

/// Looks at all that is published, and at all that odometry adds up.
std::string defectOf(const ProcessedFrame& answer) {
  RelativePose own = answer.pose;
  own.covariance = answer.own_covariance;
  std::string defect = poseDefect(answer.pose);
  if (defect.empty()) defect = poseDefect(own);
  if (defect.empty() && answer.since_key) defect = poseDefect(answer.since_key->current_in_key);
  return defect;
}

}  // namespace

void findPose(const Pipeline& pipeline, Stream& stream, ComparedPair& pair, ProcessedFrame& answer) {
  // Depth tells a motion that the images alone leave open.
  const bool open = answer.status == MatchStats::MOTION_UNKNOWN && pipeline.parameters.measuresDepth();
  if (!answer.poseValid() && !open) return;
  answer.pose = pair.result.robust.judgement.pose;
  answer.length_missing = answer.recovered && answer.status == MatchStats::OK;
  const Parameters& parameters = pipeline.parameters;
  if (answer.current->image.wanted.points || parameters.scale == ScaleMode::kPropagate || parameters.measuresMetres()) {
    triangulateInliers(pair.reference->frame.features, pair.result, answer.current->image.camera->camera, pair.points);
    pair.triangulated = true;
  }
  findLength(pipeline, stream, answer);
  if (!answer.poseValid()) {
    answer.pose = RelativePose();
    pair.triangulated = false;
    return;
  }
  if (answer.length_missing) answer.reasons.push_back({Why::kLengthUnknown});
  makePublishable(answer.status == MatchStats::OK, pipeline.options.sigma_floor, answer.pose);
  if (answer.since_key) makePublishable(true, pipeline.options.sigma_floor, answer.since_key->current_in_key);
  addSharedErrors(pipeline.options.systematic_sigma, parameters, answer);
  const std::string defect = defectOf(answer);
  if (defect.empty()) return;
  answer.status = MatchStats::RANSAC_FAILED;
  answer.reasons = {{Why::kUnfit, defect}};
  answer.pose = RelativePose();
  answer.shared.setZero();
  answer.metric_scale = false;
  answer.since_key.reset();
}

void makePublishable(bool translation_known, const SigmaFloor& floor, RelativePose& pose) {
  if (!translation_known) {
    pose.t.setZero();
    setTranslationVariance(kUnknownTranslationVariance, pose.covariance);
  }
  // Adding the floor keeps the matrix positive definite; raising single entries would not.
  pose.covariance.diagonal().head<3>().array() += floor.translation * floor.translation * pose.t.squaredNorm();
  pose.covariance.diagonal().tail<3>().array() += floor.rotation * floor.rotation;
  boundIfValid(pose.covariance);
}

std::optional<RelativePose> uncertainPose(const ProcessedFrame& answer, const SigmaFloor& floor) {
  if (answer.status != MatchStats::MOTION_UNKNOWN) return std::nullopt;
  RelativePose motion = answer.pair->result.robust.judgement.motion;
  makePublishable(!motion.t.isZero(), floor, motion);
  return poseDefect(motion).empty() ? std::optional(motion) : std::nullopt;
}

std::string poseDefect(const RelativePose& pose) {
  if (!pose.t.allFinite()) return "its translation is not finite";
  if (!pose.R.allFinite()) return "its rotation is not finite";
  if (!isRotation(pose.R)) return "its rotation matrix is not a rotation";
  if (!pose.covariance.allFinite()) return "its covariance is not finite";
  if (!isSymmetric(pose.covariance, kSymmetryTolerance)) return "its covariance is not symmetric";
  const Eigen::LLT<Covariance6d> factors(pose.covariance);
  if (factors.info() != Eigen::Success) return "its covariance is not positive definite";
  return std::string();
}

void boundCovariance(Covariance6d& covariance) {
  if (!covariance.allFinite()) covariance = Covariance6d::Identity() * kLargestVariance;
  // Products and inverses are symmetric up to rounding only.
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  for (int i = 0; i < 6; ++i) {
    const double variance = covariance(i, i);
    if (variance > kLargestVariance) {
      // Scaling a row and its column by the same factor keeps the matrix positive semi-definite.
      const double factor = std::sqrt(kLargestVariance / variance);
      covariance.row(i) *= factor;
      covariance.col(i) *= factor;
    }
    covariance(i, i) = std::clamp(covariance(i, i), kSmallestVariance, kLargestVariance);
  }
}

}  // namespace gms_ransac
