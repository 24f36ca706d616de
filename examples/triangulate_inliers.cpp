// Example subscriber: turns the inliers of every pair into points in the current camera's optical frame, in multiples
// of the baseline (metres when the message says metric_scale). For rectified images, since K alone is used.
//   rosrun gms_ransac triangulate_inliers correspondences:=/match_filter/correspondences
#include <ros/ros.h>

#include "gms_ransac/Correspondences.h"
#include "gms_ransac/correspondences_view.h"
#include "gms_ransac/triangulation.h"

void onCorrespondences(const gms_ransac::Correspondences& message) {
  if (!message.pose_valid) return;
  const gms_ransac::CorrespondencesView<gms_ransac::Correspondences> view(message);
  const Eigen::Isometry3d pose = view.currentInReference();
  gms_ransac::RelativePose motion;
  motion.R = pose.linear();
  motion.t = pose.translation();

  const Eigen::Matrix3d K_inverse = view.K().inverse();
  gms_ransac::Triangulation rays;
  for (int i = 0; i < view.size(); ++i) {
    if (!view.isInlier(i)) continue;
    const Eigen::Vector3d r = K_inverse * view.reference().col(i).cast<double>().homogeneous();
    const Eigen::Vector3d c = K_inverse * view.current().col(i).cast<double>().homogeneous();
    rays.match.push_back(i);
    rays.x_reference.push_back(r.x());
    rays.y_reference.push_back(r.y());
    rays.x_current.push_back(c.x());
    rays.y_current.push_back(c.y());
  }
  gms_ransac::triangulate(motion, gms_ransac::kMinimumParallax, rays);

  int count = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int i = 0; i < rays.size(); ++i) {
    if (!rays.valid[i]) continue;
    centre += rays.point(i);
    ++count;
  }
  if (count > 0) centre /= count;
  ROS_INFO("%d points of %d inliers, centre %.2f %.2f %.2f", count, rays.size(), centre.x(), centre.y(), centre.z());
}

int main(int argc, char** argv) {
  ros::init(argc, argv, "triangulate_inliers");
  ros::NodeHandle node;
  const ros::Subscriber subscriber = node.subscribe("correspondences", 10, onCorrespondences);
  ros::spin();
  return 0;
}
