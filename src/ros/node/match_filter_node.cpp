// match_filter_node: the match filter as a process of its own.
#include <cstdio>
#include <exception>
#include <string>

#include <ros/ros.h>

#include "methods/method.h"
#include "node/match_filter_ros.h"

namespace {

constexpr char kUsage[] =
    "match_filter_node [image:=TOPIC] [camera_info:=TOPIC] [_PARAMETER:=VALUE ...] [__name:=NAME]\n\n"
    "Matches consecutive images and publishes their correspondences and relative pose below ~ (match_filter).\n"
    "Example: rosrun gms_ransac match_filter_node image:=/camera/image_raw camera_info:=/camera/camera_info\n"
    "         _features:=1000\n"
    "match_filter_node --methods explains the values of ~method.\n"
    "Parameters: cfg/match_filter.yaml. Inside a nodelet manager: launch/match_filter.launch manager:=NAME.\n";

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--methods") {
      std::fputs(gms_ransac::methodsText().c_str(), stdout);
      return 0;
    }
    if (argument != "--help" && argument != "-h") continue;
    std::fputs(kUsage, stdout);
    return 0;
  }
  ros::init(argc, argv, "match_filter");
  const ros::NodeHandle nh, pnh("~");  // outlive the attempt: without a handle logging has ended
  try {
    const auto filter = gms_ransac::runMatchFilter(nh, pnh);
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(ros::this_node::getName() << ": " << error.what());
    return 2;
  }
  return 0;
}
