#include "frames.h"

#include <tf2_eigen/tf2_eigen.h>

namespace gms_ransac {

using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

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

geometry_msgs::TwistWithCovariance toMessage(const Vector6d& twist, const Matrix6d& covariance) {
  geometry_msgs::TwistWithCovariance message;
  message.twist = tf2::toMsg(twist);
  Eigen::Map<RowMajor6d>(message.covariance.data()) = covariance;
  return message;
}

geometry_msgs::PoseWithCovariance toMessage(const Eigen::Isometry3d& pose, const Matrix6d& covariance) {
  geometry_msgs::PoseWithCovariance message;
  message.pose = tf2::toMsg(pose);
  Eigen::Map<RowMajor6d>(message.covariance.data()) = covariance;
  return message;
}

Eigen::Isometry3d toIsometry(const RelativePose& pose) {
  Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
  isometry.linear() = pose.R;
  isometry.translation() = pose.t;
  return isometry;
}

geometry_msgs::TransformStamped relativeTransform(const RelativePose& current_in_reference,
                                                  const std_msgs::Header& current) {
  geometry_msgs::TransformStamped transform = toTransform(toIsometry(current_in_reference).inverse());
  transform.header = current;
  transform.child_frame_id = referenceFrame(current.frame_id);
  return transform;
}

}  // namespace gms_ransac
