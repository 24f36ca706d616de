#include "priors/ground_source.h"

#include <utility>

#include "tf_lookup.h"

namespace gms_ransac {

namespace {

// Standard deviation of the direction down, radians: suspension of a robot if tf knows the camera on its base, else a
// camera held level.
constexpr double kSpringSigma = 0.02, kLevelSigma = 0.17;

}  // namespace

LengthAnswer GroundSource::measure(const PriorQuery& query, const PairSeen& pair) {
  if (!pair.seen.judgement.translation_observable) return LengthAnswer();
  Ground ground =
      measureGround(pair.points, pair.seen.judgement.pose, pair.camera, prior(query.camera_frame), pair.images);
  return {ground.scale, std::move(ground.problem)};
}

GroundPrior GroundSource::prior(const std::string& camera_frame) const {
  GroundPrior prior;
  prior.camera_height = camera_height_;
  prior.down_sigma = kLevelSigma;
  Eigen::Isometry3d base_in_camera;
  if (tf_ != nullptr && !base_frame_.empty() && tf_->get(camera_frame, base_frame_, 0, base_in_camera).empty()) {
    prior.down = -base_in_camera.linear().col(2);
    prior.down_sigma = kSpringSigma;
  }
  return prior;
}

}  // namespace gms_ransac
