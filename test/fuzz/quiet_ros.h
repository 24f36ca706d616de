// ROS for fuzz targets: wall time, and no log, which would be most of the work.
#pragma once

#include <ros/console.h>
#include <ros/time.h>

namespace gms_ransac {

inline void quietRos() {
  static const bool done = [] {
    ros::Time::init();
    ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Fatal);
    ros::console::notifyLoggerLevelsChanged();
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace gms_ransac
