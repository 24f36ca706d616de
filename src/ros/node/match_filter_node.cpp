// match_filter_node: the match filter as a process of its own.
#include <exception>

#include <ros/ros.h>

#include "node/match_filter_ros.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "match_filter");
  const ros::NodeHandle nh, pnh("~");  // outlive the attempt: without a handle logging has ended
  try {
    gms_ransac::MatchFilterRos filter(nh, pnh, ros::this_node::getName());
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(ros::this_node::getName() << ": " << error.what());
    return 2;
  }
  return 0;
}
