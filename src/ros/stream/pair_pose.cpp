#include "stream/pair_pose.h"

#include <string>
#include <utility>

#include "scale/translation_scale.h"
#include "stream/status_text.h"

namespace gms_ransac {

PairPose::PairPose(const Parameters& parameters, std::shared_ptr<MotionPriors> priors)
    : parameters_(parameters), priors_(std::move(priors)) {}

void PairPose::finish(const SigmaFloor& floor, ProcessedFrame& processed) {
  scale_updated_ = false;
  if (!processed.poseValid()) return;
  processed.pose = processed.result->robust.pose;
  processed.length_missing = processed.recovered && processed.status == MatchStats::OK;
  findLength(processed);
  if (processed.length_missing) processed.text += "; the length of the motion since then is unknown";
  makePublishable(processed.status == MatchStats::OK, floor, processed.pose);
  const std::string defect = poseDefect(processed.pose);
  if (defect.empty()) return;
  processed.status = MatchStats::RANSAC_FAILED;
  processed.text = "the pose is not fit to publish: " + defect;
  processed.pose = RelativePose();
  processed.metric_scale = false;
  // The propagator may have taken wrong values from this pair: it starts anew.
  scale_updated_ = false;
}

void PairPose::advance() {
  if (scale_updated_) {
    propagator_.advance();
  } else {
    propagator_.reset();
  }
}

void PairPose::reset() {
  propagator_.reset();
  scale_updated_ = false;
}

void PairPose::findLength(ProcessedFrame& processed) {
  const ScaleMode mode = parameters_.scale;
  if (mode == ScaleMode::kPropagate || parameters_.measuresMetres()) {
    triangulateInliers(processed.reference->frame.features, processed.current->frame.features, *processed.result,
                       processed.current->camera->camera, triangulation_);
  }
  if (mode == ScaleMode::kFixed && processed.status == MatchStats::OK && !processed.recovered) {
    processed.pose = withLength(processed.pose, {parameters_.fixed_scale, 0, 1});
    processed.metric_scale = true;
  } else if (mode == ScaleMode::kPropagate) {
    propagate(processed);
  } else if (priors_ && (mode == ScaleMode::kOdometry || mode == ScaleMode::kGround)) {
    askPriors(processed);
  } else if (parameters_.measuresDepth()) {
    takeDepth(processed);
  }
}

void PairPose::propagate(ProcessedFrame& processed) {
  scale_updated_ = true;
  if (processed.status != MatchStats::OK) return propagator_.carryThroughRotation(triangulation_, *processed.result);
  const Camera& camera = processed.current->camera->camera;
  const ScaleEstimate scale = propagator_.update(triangulation_, *processed.result, camera, processed.recovered);
  processed.pose = withLength(processed.pose, scale);
  processed.length_missing &= scale.features == 0;
}

void PairPose::askPriors(ProcessedFrame& processed) {
  const PreparedFrame &reference = *processed.reference, &current = *processed.current;
  const PairSeen pair = {reference.header, current.header,         processed.result->robust,
                         triangulation_,   current.camera->camera, {reference.grey, current.grey}};
  std::string problem;
  const ScaleEstimate length = priors_->length(pair, problem);
  processed.metric_scale = length.features > 0 && processed.status == MatchStats::OK;
  if (processed.metric_scale) processed.pose = withLength(processed.pose, length);
  if (!problem.empty()) processed.text += "; no length: " + problem;
}

void PairPose::takeDepth(ProcessedFrame& processed) {
  const PreparedFrame &reference = *processed.reference, &current = *processed.current;
  const bool stereo = parameters_.input == InputKind::kStereo;
  const auto depthOf = [stereo](const PreparedFrame& frame) {
    const bool known = stereo || !frame.stereo.depth.empty();
    return known ? frame.stereo.depth : keypointDepth(frame.frame.features, frame.depth);
  };
  const ScaleEstimate scale =
      poseFromKeypointDepth(triangulation_, reference.frame.features, current.frame.features, *processed.result,
                            current.camera->camera, depthOf(reference), depthOf(current),
                            stereo ? DepthSource::kTriggeredPair : DepthSource::kRollingCamera, processed.pose);
  processed.metric_scale = scale.features > 0;
  processed.length_missing &= !processed.metric_scale;
  if (processed.metric_scale && processed.status != MatchStats::OK) {
    // Depth makes a translation observable that the images alone do not show.
    processed.status = MatchStats::OK;
    processed.text = explain(Status::kOk, *processed.result, current) + "; the translation is measured by the " +
                     (stereo ? "two cameras" : "depth image");
  }
  if (processed.metric_scale) return;
  const std::string& problem = current.depth_problem.empty() ? reference.depth_problem : current.depth_problem;
  processed.text += "; no length: " + (problem.empty() ? "too few inliers have depth" : problem);
}

}  // namespace gms_ransac
