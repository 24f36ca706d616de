#include "motion_integrator.h"

#include "publishable_pose.h"

namespace gms_ransac {

namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// [R, -R [lever]x; 0, R]: how a perturbation at one point of a rigid body moves another, `lever` away, in axes
/// turned by R.
Matrix6d leverTransform(const Eigen::Matrix3d& R, const Eigen::Vector3d& lever) {
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = m.bottomRightCorner<3, 3>() = R;
  m.topRightCorner<3, 3>() = -R * skew(lever);
  return m;
}

}  // namespace

void MotionIntegrator::restart() {
  reference_ = current_ = OdometryEstimate();
  step_ = turn_ = 0;
}

void MotionIntegrator::lose() {
  current_.pose_covariance.diagonal().head<3>().array() += step_ * step_;
  current_.pose_covariance.diagonal().tail<3>().array() += turn_ * turn_;
  boundCovariance(current_.pose_covariance);
  reference_ = current_;
}

void MotionIntegrator::add(const RelativePose& motion, bool translation_known, double seconds, bool hold_reference) {
  Matrix6d covariance = motion.covariance;
  if (translation_known) {
    step_ = motion.t.norm();
  } else {
    // Without parallax the camera has moved less than it usually does between two images.
    covariance.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() * step_ * step_;
  }
  turn_ = Eigen::AngleAxisd(motion.R).angle();

  const Eigen::Matrix3d R = reference_.pose.linear();
  current_.pose.linear() = Eigen::Quaterniond(R * motion.R).normalized().toRotationMatrix();
  current_.pose.translation() = reference_.pose.translation() + R * motion.t;
  const Matrix6d A = leverTransform(Eigen::Matrix3d::Identity(), R * motion.t);
  const Matrix6d B = leverTransform(R, Eigen::Vector3d::Zero());
  current_.pose_covariance = A * reference_.pose_covariance * A.transpose() + B * covariance * B.transpose();
  boundCovariance(current_.pose_covariance);

  const Eigen::AngleAxisd turn(motion.R);
  current_.twist.head<3>() = motion.R.transpose() * motion.t / seconds;
  current_.twist.tail<3>() = turn.axis() * turn.angle() / seconds;
  const Matrix6d C = leverTransform(motion.R.transpose(), Eigen::Vector3d::Zero()) / seconds;
  current_.twist_covariance = C * covariance * C.transpose();
  boundCovariance(current_.twist_covariance);
  if (!hold_reference) reference_ = current_;
}

OdometryEstimate MotionIntegrator::base(const Eigen::Isometry3d& camera_in_base) const {
  const Eigen::Isometry3d base_in_camera = camera_in_base.inverse();
  const Eigen::Matrix3d& X = camera_in_base.linear();
  OdometryEstimate base;
  base.pose = camera_in_base * current_.pose * base_in_camera;
  const Matrix6d P = leverTransform(X, current_.pose.linear() * base_in_camera.translation());
  base.pose_covariance = P * current_.pose_covariance * P.transpose();
  boundCovariance(base.pose_covariance);
  const Matrix6d V = leverTransform(X, base_in_camera.translation());
  base.twist = V * current_.twist;
  base.twist_covariance = V * current_.twist_covariance * V.transpose();
  boundCovariance(base.twist_covariance);
  return base;
}

}  // namespace gms_ransac
