// Methods and extractors by the names of earlier versions: still taken from launch files, YAML and dynamic_reconfigure.
#pragma once

#include <string>
#include <vector>

#include <gms_ransac/MatchFilterConfig.h>
#include <ros/node_handle.h>

namespace gms_ransac {

/// Puts today's names in place of earlier ones, on the parameter server. Returns a sentence for each.
std::vector<std::string> replaceFormerNames(const ros::NodeHandle& pnh);

/// Likewise in a request of dynamic_reconfigure.
std::vector<std::string> replaceFormerNames(MatchFilterConfig& config);

}  // namespace gms_ransac
