// Example subscriber: turns the inliers of every pair into points in the current camera's optical frame, in multiples
// of the baseline (metres when the message says metric_scale). The distortion of images that are not rectified comes
// from camera_info.
//   rosrun gms_ransac triangulate_inliers correspondences:=/match_filter/correspondences
//   camera_info:=/camera/camera_info
#include <cstdio>
#include <string>

#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>

#include "gms_ransac/Correspondences.h"
#include "gms_ransac/correspondences_view.h"
#include "gms_ransac/triangulation.h"

sensor_msgs::CameraInfo camera_info;  // the latest

void onCameraInfo(const sensor_msgs::CameraInfo& message) { camera_info = message; }

void onCorrespondences(const gms_ransac::Correspondences& message) try {
  if (!message.pose_valid) return;
  const gms_ransac::CorrespondencesView<gms_ransac::Correspondences> view(message);
  const Eigen::Isometry3d pose = view.currentInReference();
  gms_ransac::RelativePose motion;
  motion.R = pose.linear();
  motion.t = pose.translation();

  const cv::Mat reference = view.normalized(view.referencePoints(), camera_info);
  const cv::Mat current = view.normalized(view.currentPoints(), camera_info);
  gms_ransac::Triangulation rays;
  for (int i = 0; i < view.size(); ++i) {
    if (!view.isInlier(i)) continue;
    const auto r = reference.at<cv::Point2f>(i), c = current.at<cv::Point2f>(i);
    rays.row.push_back(i);
    rays.x_reference.push_back(r.x);
    rays.y_reference.push_back(r.y);
    rays.x_current.push_back(c.x);
    rays.y_current.push_back(c.y);
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
} catch (const std::invalid_argument& problem) {
  ROS_WARN_ONCE("%s (camera_info is read from %s)", problem.what(), ros::names::resolve("camera_info").c_str());
}

int main(int argc, char** argv) {
  if (argc > 1 && argv[1] == std::string("--help")) {
    std::puts(
        "triangulate_inliers correspondences:=/match_filter/correspondences"
        " camera_info:=/camera/camera_info\n\nPrints the triangulated inliers of every pair.");
    return 0;
  }
  ros::init(argc, argv, "triangulate_inliers");
  ros::NodeHandle node;
  const ros::Subscriber info_subscriber = node.subscribe("camera_info", 1, onCameraInfo);
  const ros::Subscriber subscriber = node.subscribe("correspondences", 10, onCorrespondences);
  ros::spin();
  return 0;
}
