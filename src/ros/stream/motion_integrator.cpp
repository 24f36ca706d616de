#include "stream/motion_integrator.h"

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
  const bool usual = !motion.after_loss && !motion.at_rest;
  if (usual) {
    known_.turn = Eigen::AngleAxisd(pair.R).angle();
    known_.turn_seconds = motion.seconds;
  }
  if (motion.translation_known) {
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
  } else {
    double step = known_.step > 0 ? known_.step : first_step_;
    if (known_.step > 0 && motion.parallax_px > 0 && known_.parallax_px > 0) {
      step *= motion.parallax_px / known_.parallax_px;
    }
    RelativePose widened = pair;
    widened.covariance.topLeftCorner<3, 3>().setIdentity();
    widened.covariance.topLeftCorner<3, 3>() *= addInLine(step, current_.missed_step);
    chain(reference_, widened);
  }
  setTwist(motion);
  if (!motion.reference_held) reference_ = current_;
}

void MotionIntegrator::set(const Eigen::Isometry3d& pose, const Matrix6d& covariance) {
  const Eigen::Isometry3d step = pose * current_.estimate.pose.inverse();
  for (Place* place : {&key_, &reference_, &current_}) {
    place->estimate.pose = step * place->estimate.pose;
    place->estimate.pose_covariance = covariance;
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
  estimate.twist_covariance = C * pair.covariance * C.transpose();
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
  base.pose_covariance = P * current_.estimate.pose_covariance * P.transpose();
  const Matrix6d V = leverTransform(X, base_in_camera.translation());
  base.twist = V * current_.estimate.twist;
  base.twist_covariance = V * current_.estimate.twist_covariance * V.transpose();
  for (Matrix6d* covariance : {&base.pose_covariance, &base.twist_covariance}) boundCovariance(*covariance);
  return base;
}

}  // namespace gms_ransac
