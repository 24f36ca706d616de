#include "stream/step.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "gms_ransac/camera.h"
#include "guard.h"

namespace gms_ransac {

namespace {

std::shared_ptr<PreparedFrame> recalibrated(const std::shared_ptr<PreparedFrame>& reference,
                                            const std::shared_ptr<const CameraModel>& camera) {
  if (!reference->image.camera || reference->image.camera == camera) return reference;
  const Camera &before = reference->image.camera->camera, &now = camera->camera;
  if (!before.calibrated() || !now.calibrated() || before == now) return reference;
  auto moved = std::make_shared<PreparedFrame>(*reference);
  for (cv::KeyPoint& keypoint : moved->frame.features.keypoints) {
    const cv::Point2f pixel = pixelOf(now, rayOf(before, keypoint.pt));
    if (std::isfinite(pixel.x) && std::isfinite(pixel.y)) keypoint.pt = pixel;
  }
  moved->image.grey.release();  // it does not show the keypoints where they are now
  moved->image.camera = camera;
  return moved;
}

}  // namespace

std::shared_ptr<ComparedPair> PairPool::acquire() {
  const auto is_free = [](const std::shared_ptr<ComparedPair>& pair) { return pair.use_count() == 1; };
  const auto found = std::find_if(pairs_.begin(), pairs_.end(), is_free);
  if (found != pairs_.end()) return *found;
  return pairs_.emplace_back(std::make_shared<ComparedPair>());
}

void PairPool::releaseFrames() {
  for (const std::shared_ptr<ComparedPair>& pair : pairs_) {
    if (pair.use_count() == 1) pair->reference.reset();
  }
}

void Comparison::compare() {
  const auto work_on = [&] {
    RotationSource* sensor = pipeline.priors ? pipeline.priors->rotation() : nullptr;
    // The time between the two is unsure.
    if (current->image.stamp_verdict == StampVerdict::kAfterLate) sensor = nullptr;
    RotationAnswer rotation;
    if (sensor) rotation = sensor->ask(pipeline.priors->query(stream.reference->image.header, current->image.header));
    const std::shared_ptr<ComparedPair> pair =
        attempt(stream.reference, rotation.prior ? &*rotation.prior : nullptr, &stream.past);
    stream.reference = pair->reference;
    if (rotation.prior && pair->result.robust.judgement.pose_found) sensor->compare(rotation, pair->result.robust);
    conclude(pair);
    if (!rotation.problem.empty()) because(Why::kNoPrior, rotation.problem);
  };
  guarded(work_on, [&](const std::string& what) { fail(stream.reference, what); });
}

std::shared_ptr<ComparedPair> Comparison::attempt(const std::shared_ptr<PreparedFrame>& reference,
                                                  const RotationPrior* prior, Past* past) {
  std::shared_ptr<ComparedPair> pair = pairs.acquire();
  pair->reference = recalibrated(reference, current->image.camera);
  pair->triangulated = false;
  pipeline.filter.setCamera(current->image.camera->camera);
  pipeline.filter.filter(pair->reference->frame, current->frame, pair->result, prior, past);
  answer.times.match += pair->result.times.match;
  answer.times.gms += pair->result.times.gms;
  answer.times.ransac += pair->result.times.ransac;
  return pair;
}

void Comparison::conclude(const std::shared_ptr<ComparedPair>& pair) {
  answer.pair = pair;
  answer.status = static_cast<uint8_t>(pair->result.status);
  because(Why::kCompared);
  stream.tracks.link(pair->result);
  pair->track_ids = stream.tracks.ids();
  pair->track_lengths = stream.tracks.lengths();
  findPose(pipeline, stream, *pair, answer);
  if (pipeline.parameters.publish_uncertain) answer.uncertain = uncertainPose(answer, pipeline.options.sigma_floor);
}

void Comparison::fail(const std::shared_ptr<PreparedFrame>& reference, const std::string& what) {
  const std::shared_ptr<ComparedPair> pair = pairs.acquire();
  pair->reference = reference;
  pair->result.clear(Status::kRansacFailed);
  pair->track_ids.clear();
  pair->track_lengths.clear();
  pair->triangulated = false;
  stream.past = Past();
  stream.tracks.reset();
  stream.scale.reset();
  stream.key = KeyFrame();
  answer.pair = pair;
  answer.recovered = false;
  answer.status = MatchStats::RANSAC_FAILED;
  answer.reasons = {{Why::kFailed, what}};
}

}  // namespace gms_ransac
