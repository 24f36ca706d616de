// One received image and the messages that belong to it.
#pragma once

#include <gms_ransac/Keypoints.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

namespace gms_ransac {

struct ImageWithInfo {
  sensor_msgs::ImageConstPtr image;             ///< with `keypoints` their header and size alone, without pixels
  KeypointsConstPtr keypoints;                  ///< with ~input keypoints: the features of the image; else null
  sensor_msgs::CameraInfoConstPtr camera_info;  ///< null: none has arrived, or it was replaced by parameters
  sensor_msgs::ImageConstPtr depth;             ///< with ~scale depth; null: none came with the image
  sensor_msgs::ImageConstPtr mask;              ///< null: none has arrived, or none with the image's stamp
  sensor_msgs::ImageConstPtr reference;         ///< with ~input pair: what `image` is compared with
  sensor_msgs::ImageConstPtr right;             ///< with ~input stereo; null: none came with the image
  sensor_msgs::CameraInfoConstPtr right_info;   ///< of `right`; null: none has arrived
  ros::Time received;
};

}  // namespace gms_ransac
