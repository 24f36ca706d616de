#include "stream/odometry.h"

#include <algorithm>

#include "parameters.h"
#include "past/standstill.h"
#include "stream/processed_frame.h"
#include "two_view/pose_model.h"
#include "two_view/translation_variance.h"

namespace gms_ransac {

namespace {

/// Size of an unknown rotation before any was seen, radians: half the view of a usual camera.
constexpr double kFirstTurn = 0.5;

/// Growth of the variance by a further motion in the same direction; adds `size` to `missed`.
double addInLine(double size, double& missed) {
  const double before = missed * missed;
  missed += size;
  return missed * missed - before;
}

/// Gives a motion of known direction the usual length, with a variance to match; 0: the usual length is not known.
RelativePose withUsualLength(RelativePose motion, double length) {
  if (length == 0) {
    makePublishable(false, SigmaFloor{0, 0}, motion);
  } else {
    motion.t *= length / motion.t.norm();
    setTranslationVariance(length * length, motion.covariance);
  }
  return motion;
}

/// The pose with the part of its covariance that no other pair shares.
RelativePose ownPose(const ProcessedFrame& answer) {
  RelativePose pose = answer.pose;
  pose.covariance = answer.own_covariance;
  return pose;
}

/// A camera that stands still moves by less than the least drift that is seen, of a view that is so far away.
RelativePose rest(const ProcessedFrame& answer) {
  constexpr double kDepth = 10;
  RelativePose motion = answer.poseValid() ? ownPose(answer) : RelativePose();
  const double angle = kMostDrift / answer.current->image.camera->camera.meanFocalLength();
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
  const double passed = stamp - place.stamp.value_or(stamp);
  // Stamps that were set back do not show how long it took: two images, after which it is noticed.
  place.lose(passed >= 0 ? passed : 2 * place.usualInterval());
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

void forgetLength(bool at_rest, OdometryEstimate& estimate) {
  setTranslationVariance(kNoLengthVariance, estimate.pose_covariance);
  if (!at_rest) setTranslationVariance(kNoLengthVariance, estimate.twist_covariance);
}

void MotionIntegrator::restart() {
  key_ = reference_ = current_ = Place();
  known_ = Usual();
  stamp.reset();
}

void MotionIntegrator::lose(double seconds) {
  const double usual_step = known_.step > 0 ? known_.step * seconds / known_.step_seconds : first_step_;
  const double usual_turn = known_.turn_seconds > 0 ? known_.turn * seconds / known_.turn_seconds : kFirstTurn;
  Matrix6d& covariance = current_.estimate.pose_covariance;
  covariance.diagonal().head<3>().array() += addInLine(usual_step, current_.missed_step);
  covariance.diagonal().tail<3>().array() += addInLine(usual_turn, current_.missed_turn);
  reference_ = current_;
}

void MotionIntegrator::add(const PairMotion& motion) {
  const RelativePose& pair = motion.current_in_reference;
  current_ = reference_;
  current_.missed_turn = 0;
  current_.shared = chained(reference_.shared, reference_.estimate.pose.linear(), motion.shared, pair.t);
  const bool usual = !motion.after_loss && !motion.at_rest;
  if (usual) {
    known_.turn = Eigen::AngleAxisd(pair.R).angle();
    known_.turn_seconds = motion.seconds;
  }
  if (!motion.translation_known || motion.guessed_length > 0) {
    RelativePose widened = pair;
    const double size = motion.translation_known ? motion.guessed_length : usualStep(motion.parallax_px);
    setTranslationVariance(addInLine(size, current_.missed_step), widened.covariance);
    chain(reference_, widened);
  } else {
    if (usual) {
      known_.step = pair.t.norm();
      known_.step_seconds = motion.seconds;
      known_.parallax_px = motion.parallax_px;
    }
    current_.missed_step = 0;
    if (motion.since_key) {
      if (motion.since_key->key_is_reference) key_ = reference_;
      chain(key_, motion.since_key->current_in_key);
    } else {
      chain(reference_, pair);
    }
  }
  setTwist(motion);
  if (!motion.reference_held) reference_ = current_;
}

double MotionIntegrator::usualStep(double parallax_px) const {
  if (known_.step == 0) return first_step_;
  return parallax_px > 0 && known_.parallax_px > 0 ? known_.step * parallax_px / known_.parallax_px : known_.step;
}

void MotionIntegrator::set(const Eigen::Isometry3d& pose, const Matrix6d& covariance) {
  const Eigen::Isometry3d step = pose * current_.estimate.pose.inverse();
  for (Place* place : {&key_, &reference_, &current_}) {
    place->estimate.pose = step * place->estimate.pose;
    place->estimate.pose_covariance = covariance;
    place->shared.setZero();
    place->missed_step = place->missed_turn = 0;
  }
  current_.estimate.pose = pose;
}

void MotionIntegrator::chain(const Place& from, const RelativePose& motion) {
  const OdometryEstimate& before = from.estimate;
  const RelativePose place = chained({before.pose.linear(), before.pose.translation(), before.pose_covariance}, motion);
  current_.estimate.pose.linear() = place.R;
  current_.estimate.pose.translation() = place.t;
  current_.estimate.pose_covariance = place.covariance;
}

void MotionIntegrator::setTwist(const PairMotion& motion) {
  const RelativePose& pair = motion.current_in_reference;
  OdometryEstimate& estimate = current_.estimate;
  const Eigen::AngleAxisd turn(pair.R);
  estimate.twist.head<3>() = pair.R.transpose() * pair.t / motion.seconds;
  estimate.twist.tail<3>() = turn.axis() * turn.angle() / motion.seconds;
  const Matrix6d C = leverTransform(pair.R.transpose(), Eigen::Vector3d::Zero()) / motion.seconds;
  estimate.twist_covariance = C * (pair.covariance + motion.shared * motion.shared.transpose()) * C.transpose();
  // The twist is that of the pair alone: of a translation that it does not tell it says nothing, nor of the velocity
  // now after a loss.
  if (motion.after_loss) {
    estimate.twist_covariance = Matrix6d::Identity() * kLargestVariance;
  } else if (!motion.translation_known) {
    estimate.twist_covariance.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() * kLargestVariance;
  }
}

OdometryEstimate MotionIntegrator::base(const Eigen::Isometry3d& camera_in_base) const {
  const Eigen::Isometry3d base_in_camera = camera_in_base.inverse();
  const Eigen::Matrix3d& X = camera_in_base.linear();
  OdometryEstimate base;
  base.pose = camera_in_base * current_.estimate.pose * base_in_camera;
  const Matrix6d P = leverTransform(X, current_.estimate.pose.linear() * base_in_camera.translation());
  base.pose_covariance =
      P * (current_.estimate.pose_covariance + current_.shared * current_.shared.transpose()) * P.transpose();
  const Matrix6d V = leverTransform(X, base_in_camera.translation());
  base.twist = V * current_.estimate.twist;
  base.twist_covariance = V * current_.estimate.twist_covariance * V.transpose();
  for (Matrix6d* covariance : {&base.pose_covariance, &base.twist_covariance}) boundCovariance(*covariance);
  return base;
}

void integrate(const Parameters& parameters, MotionIntegrator& place, ProcessedFrame& answer) {
  const double now = answer.current->stamp(), from = answer.pair ? answer.pair->reference->stamp() : now;
  const bool begun = place.stamp.has_value();
  if (answer.continuity == Continuity::kRestarted || (!begun && answer.continuity == Continuity::kContinuous)) {
    restart(from, place, answer);
    // The odometry begins here; a camera that is not calibrated has none.
    const bool bad_pair = answer.status == MatchStats::BAD_IMAGE;
    if (answer.pair == nullptr && !bad_pair && answer.current->image.camera->camera.calibrated()) answer.place = place;
  } else if (answer.continuity == Continuity::kBroken && begun) {
    lose(now, place);
  }
  if (answer.pair == nullptr) return;
  const double seconds = now - from;
  if (parameters.input == InputKind::kPair && seconds > 0 && !continueWithPair(from, now, place, answer)) return;
  const bool at_rest = answer.atRest() && answer.current->image.camera->camera.calibrated();
  if (!(answer.poseValid() || at_rest) || seconds <= 0) {
    // An image that was only skipped leaves the reference, and with it the motion, where it was.
    if (answer.status != MatchStats::TOO_FEW_KEYPOINTS) lose(now, place);
    return;
  }
  PairMotion motion = {at_rest ? rest(answer) : ownPose(answer),
                       seconds,
                       at_rest || answer.status == MatchStats::OK,
                       answer.reference_held,
                       answer.pair->result.robust.judgement.median_parallax_px,
                       answer.recovered || !answer.velocity_known,
                       at_rest,
                       answer.since_key,
                       at_rest ? SharedErrors(SharedErrors::Zero()) : answer.shared};
  const bool without_metres = parameters.measuresMetres() && !answer.metric_scale;
  if (motion.translation_known && !at_rest && (without_metres || answer.length_missing)) {
    motion.guessed_length = answer.recovered ? place.stepOf(seconds) : place.step();
    motion.translation_known = motion.guessed_length > 0;
    motion.shared.topRows<3>() *= motion.guessed_length / answer.pose.t.norm();
    motion.current_in_reference = withUsualLength(motion.current_in_reference, motion.guessed_length);
  }
  place.add(motion);
  place.stamp = now;
  answer.place = place;
}

}  // namespace gms_ransac
