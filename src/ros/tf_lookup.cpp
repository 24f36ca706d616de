#include "tf_lookup.h"

#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include "frames.h"

namespace gms_ransac {

namespace {

/// Why a lookup failed with `error`: which frame has no publisher, else the message of tf2.
std::string whatTfLacks(const tf2_ros::Buffer& buffer, const std::string& target, const std::string& source,
                        const std::string& error) {
  for (const std::string& frame : {source, target}) {
    if (!buffer._frameExists(frame)) {
      return "no transform names " + frame + "; publish it by the robot's model or a static_transform_publisher";
    }
  }
  return error;
}

}  // namespace

TfLookup::TfLookup(const ros::NodeHandle& nh)
    : buffer_(std::make_unique<tf2_ros::Buffer>()),
      listener_(std::make_unique<tf2_ros::TransformListener>(*buffer_, nh)) {}

TfLookup::~TfLookup() = default;

std::string TfLookup::get(const std::string& target, const std::string& source, double stamp,
                          Eigen::Isometry3d& transform) {
  transform.setIdentity();
  if (target == source) return std::string();
  try {
    transform = toIsometry(buffer_->lookupTransform(target, source, ros::Time(stamp)));
    return std::string();
  } catch (const std::exception& error) {  // ros::Time throws where a stamp is none
    return "tf does not know " + source + " in " + target + ": " + whatTfLacks(*buffer_, target, source, error.what());
  }
}

void TfLookup::clear() { buffer_->clear(); }

}  // namespace gms_ransac
