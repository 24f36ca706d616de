// Frame names, and the core's pose as messages and transforms.
#pragma once

#include <string>

#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/TransformStamped.h>
#include <std_msgs/Header.h>

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

/// tf2 refuses names that start with a slash, and many bags have them.
std::string withoutLeadingSlash(const std::string& frame);

/// The child of the relative transform: "<camera frame>_reference".
std::string referenceFrame(const std::string& camera_frame);

geometry_msgs::PoseWithCovariance toPoseWithCovariance(const RelativePose& pose);

/// Where the reference camera stood, seen from the current one: camera frame -> its reference frame. A leaf of its
/// own, so no frame gets a second parent.
geometry_msgs::TransformStamped relativeTransform(const RelativePose& current_in_reference,
                                                  const std_msgs::Header& current);

}  // namespace gms_ransac
