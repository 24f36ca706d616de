#include "stream/shared_errors.h"

#include "two_view/pose_model.h"

namespace gms_ransac {

namespace {

/// Products of v with a factor and with a small rotation, each unknown: four columns, the same variance in each axis.
Eigen::Matrix<double, 3, 4> scaledAndRotated(const Eigen::Vector3d& v) {
  Eigen::Matrix<double, 3, 4> columns;
  columns << v, -crossMatrix(v);
  return columns;
}

}  // namespace

SharedErrors sharedErrors(double share, const RelativePose& motion, double parallax) {
  const Eigen::Vector3d rotation = rotationVector(motion.R);
  const double length = motion.t.norm(), distance = parallax > 0 ? length / parallax : 0;
  SharedErrors errors = SharedErrors::Zero();
  errors.block<3, 4>(0, 0) = share * scaledAndRotated(motion.t);
  errors.block<3, 4>(0, 4) = share * distance * scaledAndRotated(rotation);
  errors.block<3, 4>(3, 8) = share * scaledAndRotated(rotation);
  if (distance > 0) errors.block<3, 4>(3, 12) = share / distance * scaledAndRotated(motion.t);
  return errors;
}

SharedErrors chained(const SharedErrors& b_in_a, const Eigen::Matrix3d& R, const SharedErrors& c_in_b,
                     const Eigen::Vector3d& t) {
  return leverTransform(Eigen::Matrix3d::Identity(), R * t) * b_in_a +
         leverTransform(R, Eigen::Vector3d::Zero()) * c_in_b;
}

}  // namespace gms_ransac
