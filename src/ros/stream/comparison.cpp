#include "stream/step.h"

#include <cmath>
#include <optional>

#include "gms_ransac/camera.h"
#include "guard.h"

namespace gms_ransac {

namespace {

std::shared_ptr<PreparedFrame> recalibrated(const std::shared_ptr<PreparedFrame>& reference,
                                            const std::shared_ptr<const CameraModel>& camera) {
  if (!reference->camera || reference->camera == camera) return reference;
  const Camera &before = reference->camera->camera, &now = camera->camera;
  if (!before.calibrated() || !now.calibrated() || before == now) return reference;
  auto moved = std::make_shared<PreparedFrame>(*reference);
  for (cv::KeyPoint& keypoint : moved->frame.features.keypoints) {
    const cv::Point2f pixel = pixelOf(now, rayOf(before, keypoint.pt));
    if (std::isfinite(pixel.x) && std::isfinite(pixel.y)) keypoint.pt = pixel;
  }
  moved->camera = camera;
  return moved;
}

}  // namespace

void Comparison::compare() {
  const auto work_on = [&] {
    std::string without_prior;
    std::optional<RotationPrior> prior;
    MotionPriors* priors = pipeline.priors.get();
    const bool interval_known = current->stamp_verdict != StampVerdict::kAfterLate;
    if (priors && interval_known) prior = priors->rotation(stream.reference->header, current->header, without_prior);
    match(stream.reference, work.result, prior ? &*prior : nullptr, &stream.past);
    if (prior && work.result.robust.pose_found) priors->learn(work.result.robust);
    answerBy(stream.reference);
    conclude();
    if (!without_prior.empty()) because(Why::kNoPrior, without_prior);
  };
  guarded(work_on, [&](const std::string& what) {
    answerBy(stream.reference);
    fail(what);
  });
}

void Comparison::match(std::shared_ptr<PreparedFrame>& reference, MatchResult& result, const RotationPrior* prior,
                       Past* past) {
  reference = recalibrated(reference, current->camera);
  pipeline.filter.setCamera(current->camera->camera);
  pipeline.filter.filter(reference->frame, current->frame, result, prior, past);
  work.spent.match += result.times.match;
  work.spent.gms += result.times.gms;
  work.spent.ransac += result.times.ransac;
}

void Comparison::answerBy(const std::shared_ptr<PreparedFrame>& reference) {
  work.reference = reference;
  answer.reference = reference.get();
  answer.result = &work.result;
}

void Comparison::conclude() {
  answer.status = static_cast<uint8_t>(work.result.status);
  because(Why::kCompared);
  stream.tracks.link(work.result);
  answer.track_ids = &stream.tracks.ids();
  answer.track_lengths = &stream.tracks.lengths();
  findPose(pipeline, stream, work.points, answer);
}

void Comparison::fail(const std::string& what) {
  work.result.clear(Status::kRansacFailed);
  stream.past = Past();
  stream.tracks.reset();
  stream.scale.reset();
  stream.key = KeyFrame();
  answer.status = MatchStats::RANSAC_FAILED;
  answer.reasons = {{Why::kFailed, what}};
}

void Comparison::reject(MatchResult& result) {
  result.inliers = 0;
  result.robust.reject();
  result.status = Status::kRansacFailed;
}

}  // namespace gms_ransac
