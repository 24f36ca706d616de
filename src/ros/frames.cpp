#include "frames.h"

#include <tf2_eigen/tf2_eigen.h>
#include <Eigen/Geometry>

namespace gms_ransac {

std::string withoutLeadingSlash(const std::string& frame) {
  const size_t start = frame.find_first_not_of('/');
  return start == std::string::npos ? std::string() : frame.substr(start);
}

std::string referenceFrame(const std::string& camera_frame) { return camera_frame + "_reference"; }

geometry_msgs::Pose toPoseMessage(const RelativePose& pose) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(pose.R).normalized();
  geometry_msgs::Pose message;
  message.position.x = pose.t.x();
  message.position.y = pose.t.y();
  message.position.z = pose.t.z();
  message.orientation.x = q.x();
  message.orientation.y = q.y();
  message.orientation.z = q.z();
  message.orientation.w = q.w();
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
