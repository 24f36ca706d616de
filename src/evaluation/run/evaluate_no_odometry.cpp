// `evaluate odometry` in a build without ROS.
#include <stdexcept>

#include "run/evaluate_commands.h"

namespace gms_ransac {

int evaluateOdometry(const Arguments& /*arguments*/) {
  throw std::invalid_argument("evaluate odometry runs the stream of the node, and this build is without ROS");
}

}  // namespace gms_ransac
