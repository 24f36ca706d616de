#include "stream/odometry.h"

#include <algorithm>

#include "standstill.h"

namespace gms_ransac {

namespace {

/// A motion whose direction alone is known: taken to be about so long; 0: that is not known either.
RelativePose withUsualLength(RelativePose motion, double length) {
  if (length == 0) {
    makePublishable(false, SigmaFloor{0, 0}, motion);
  } else {
    motion.t *= length / motion.t.norm();
    setTranslationVariance(length * length, motion.covariance);
  }
  return motion;
}

/// A camera that stands still moves by less than the least drift that is seen, of a view that is so far away.
RelativePose rest(const ProcessedFrame& answer) {
  constexpr double kDepth = 10;
  RelativePose motion = answer.poseValid() ? answer.pose : RelativePose();
  const double angle = kMostDrift / answer.current->camera->camera.meanFocalLength();
  if (!answer.poseValid()) motion.covariance = Matrix6d::Identity() * angle * angle;
  motion.t.setZero();
  setTranslationVariance(angle * angle * kDepth * kDepth, motion.covariance);
  return motion;
}

void restart(double stamp, MotionIntegrator& place, ProcessedFrame& answer) {
  place.restart();
  place.stamp = stamp;
  answer.place_restarted = true;
}

/// The motion since the place is not known.
void lose(double stamp, MotionIntegrator& place) {
  place.lose(std::max(0.0, stamp - place.stamp.value_or(stamp)));
  place.stamp = stamp;
}

/// Brings `place` to the reference of a pair, which need not be the last image. False: the pair begins before the place
/// and would count a motion twice.
bool continueWithPair(double from, double now, MotionIntegrator& place, ProcessedFrame& answer) {
  if (!place.stamp || now < *place.stamp) restart(from, place, answer);
  if (from > *place.stamp) lose(from, place);
  return from == *place.stamp;
}

}  // namespace

void integrate(const Parameters& parameters, MotionIntegrator& place, ProcessedFrame& answer) {
  const double now = answer.current->stamp(), from = answer.reference ? answer.reference->stamp() : now;
  if (answer.continuity == Continuity::kRestarted || answer.status == MatchStats::FIRST_FRAME) {
    restart(from, place, answer);
    // The odometry begins here; a camera that is not calibrated has none.
    if (answer.result == nullptr && answer.current->camera->camera.calibrated()) answer.place = &place;
  } else if (answer.continuity == Continuity::kBroken) {
    lose(now, place);
  }
  if (answer.result == nullptr) return;
  const double seconds = now - from;
  if (parameters.input == InputKind::kPair && seconds > 0 && !continueWithPair(from, now, place, answer)) return;
  const bool at_rest = answer.atRest() && answer.current->camera->camera.calibrated();
  if (!(answer.poseValid() || at_rest) || seconds <= 0) {
    // An image that was only skipped leaves the reference, and with it the motion, where it was.
    if (answer.status != MatchStats::TOO_FEW_KEYPOINTS) lose(now, place);
    return;
  }
  PairMotion motion = {at_rest ? rest(answer) : answer.pose,
                       seconds,
                       at_rest || answer.status == MatchStats::OK,
                       answer.reference_held,
                       answer.result->robust.median_parallax_px,
                       answer.recovered,
                       at_rest,
                       answer.since_key};
  const bool without_metres = parameters.measuresMetres() && !answer.metric_scale;
  if (motion.translation_known && !at_rest && (without_metres || answer.length_missing)) {
    const double length = answer.recovered ? place.stepOf(seconds) : place.step();
    motion.current_in_reference = withUsualLength(answer.pose, length);
    motion.translation_known = length > 0;
  }
  place.add(motion);
  place.stamp = now;
  answer.place = &place;
}

}  // namespace gms_ransac
