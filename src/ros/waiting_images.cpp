#include "waiting_images.h"

#include <algorithm>

namespace gms_ransac {

void WaitingImages::add(const ImageWithInfo& input, double now) { waiting_.push_back({input, now}); }

void WaitingImages::setCameraInfo(const sensor_msgs::CameraInfoConstPtr& info) { latest_info_ = info; }

void WaitingImages::addMask(const sensor_msgs::ImageConstPtr& mask) {
  masks_.push_back(mask);
  if (masks_.size() > (options_.for_mask ? options_.capacity : 1)) masks_.pop_front();
}

void WaitingImages::clear() {
  waiting_.clear();
  if (options_.for_mask) masks_.clear();
}

std::vector<ImageWithInfo> WaitingImages::settled(double now) {
  std::vector<ImageWithInfo> ready;
  while (!waiting_.empty()) {
    ImageWithInfo& input = waiting_.front().input;
    if (lacksCameraInfo(input)) {
      if (!overdue(now)) break;
      gave_up_camera_info_ = true;
    }
    input.mask = maskOf(*input.image);
    if (options_.for_mask && !input.mask && !masksPassed(input.image->header.stamp) && !overdue(now)) break;
    if (!input.camera_info) input.camera_info = latest_info_;
    input.right_info = latest_right_info_;
    ready.push_back(input);
    waiting_.pop_front();
  }
  return ready;
}

bool WaitingImages::lacksCameraInfo(const ImageWithInfo& input) const {
  const bool left = options_.for_camera_info && !input.camera_info && !latest_info_;
  const bool right = options_.for_right_info && !latest_right_info_;
  return (left || right) && !gave_up_camera_info_;
}

sensor_msgs::ImageConstPtr WaitingImages::maskOf(const sensor_msgs::Image& image) const {
  if (!options_.for_mask) return masks_.empty() ? nullptr : masks_.back();
  const auto same = [&](const sensor_msgs::ImageConstPtr& mask) { return mask->header.stamp == image.header.stamp; };
  const auto found = std::find_if(masks_.begin(), masks_.end(), same);
  return found == masks_.end() ? nullptr : *found;
}

bool WaitingImages::masksPassed(const ros::Time& stamp) const {
  return !masks_.empty() && masks_.back()->header.stamp > stamp;
}

bool WaitingImages::overdue(double now) const {
  return waiting_.size() > options_.capacity || now - waiting_.front().since >= options_.patience;
}

}  // namespace gms_ransac
