#include "frames.h"

#include <tf2_eigen/tf2_eigen.h>

namespace gms_ransac {

std::string withoutLeadingSlash(const std::string& frame) {
  const size_t start = frame.find_first_not_of('/');
  return start == std::string::npos ? std::string() : frame.substr(start);
}

std::string referenceFrame(const std::string& camera_frame) { return camera_frame + "_reference"; }

geometry_msgs::Point toMessage(const Eigen::Vector3d& point) { return tf2::toMsg(point); }

geometry_msgs::Pose toMessage(const Eigen::Isometry3d& pose) { return tf2::toMsg(pose); }

geometry_msgs::TransformStamped toTransform(const Eigen::Isometry3d& transform) {
  return tf2::eigenToTransform(transform);
}

Eigen::Isometry3d toIsometry(const geometry_msgs::TransformStamped& transform) {
  return tf2::transformToEigen(transform);
}

geometry_msgs::PoseWithCovariance toPoseWithCovariance(const RelativePose& pose) {
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  isometry.linear() = pose.R;
  isometry.translation() = pose.t;
  geometry_msgs::PoseWithCovariance message;
  message.pose = tf2::toMsg(isometry);
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.covariance.data()) = pose.covariance;
  return message;
}

geometry_msgs::TransformStamped relativeTransform(const RelativePose& current_in_reference,
                                                  const std_msgs::Header& current) {
  Eigen::Isometry3d reference_in_current = Eigen::Isometry3d::Identity();
  reference_in_current.linear() = current_in_reference.R.transpose();
  reference_in_current.translation() = -(current_in_reference.R.transpose() * current_in_reference.t);
  geometry_msgs::TransformStamped transform = tf2::eigenToTransform(reference_in_current);
  transform.header = current;
  transform.child_frame_id = referenceFrame(current.frame_id);
  return transform;
}

}  // namespace gms_ransac
