// Frame names, and the core's pose as messages and transforms.
#pragma once

#include <string>

#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/TransformStamped.h>
#include <geometry_msgs/TwistWithCovariance.h>
#include <std_msgs/Header.h>
#include <Eigen/Geometry>

#include "gms_ransac/relative_pose.h"

namespace gms_ransac {

using Matrix6d = Covariance6d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// tf2 refuses names that start with a slash, and many bags have them.
std::string withoutLeadingSlash(const std::string& frame);

/// The child of the relative transform: "<camera frame>_reference".
std::string referenceFrame(const std::string& camera_frame);

// As tf2_eigen has them, whose header costs every file that includes it more than the rest of the file.
geometry_msgs::Point toMessage(const Eigen::Vector3d& point);
geometry_msgs::Pose toMessage(const Eigen::Isometry3d& pose);
geometry_msgs::TransformStamped toTransform(const Eigen::Isometry3d& transform);
Eigen::Isometry3d toIsometry(const geometry_msgs::TransformStamped& transform);
/// `twist`: linear, angular.
geometry_msgs::TwistWithCovariance toMessage(const Vector6d& twist, const Matrix6d& covariance);
geometry_msgs::PoseWithCovariance toMessage(const Eigen::Isometry3d& pose, const Matrix6d& covariance);

Eigen::Isometry3d toIsometry(const RelativePose& pose);

/// Pose of the reference camera in the current one: camera frame -> its reference frame. A leaf of its
/// own, so no frame gets a second parent.
geometry_msgs::TransformStamped relativeTransform(const RelativePose& current_in_reference,
                                                  const std_msgs::Header& current);

}  // namespace gms_ransac
