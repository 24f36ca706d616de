// The match filter in a ROS graph: parameters, inputs, worker and outputs put together. The nodelet and the node are
// shells over this.
#pragma once

#include <memory>

namespace ros {
class NodeHandle;
}

namespace gms_ransac {

/// Runs until the result is destroyed. Inputs are relative to `nh`, outputs and parameters to `pnh`. Throws
/// std::invalid_argument with a sentence that names the parameter when one is wrong.
std::shared_ptr<void> runMatchFilter(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);

}  // namespace gms_ransac
