#include "input/waiting_images.h"

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
  passed_.reset();
  if (options_.for_mask) masks_.clear();
}

std::vector<ImageWithInfo> WaitingImages::settled(double now) {
  watchSensors(now);
  std::vector<ImageWithInfo> ready;
  while (!waiting_.empty()) {
    ImageWithInfo& input = waiting_.front().input;
    if (lacksCameraInfo(input)) {
      if (!overdue(now)) break;
      gave_up_camera_info_ = true;
    }
    if (waitsForSensors(now)) break;
    input.mask = maskOf(*input.image);
    if (options_.for_mask && !input.mask && !masksPassed(input.image->header.stamp) && !overdue(now)) break;
    if (!input.camera_info) input.camera_info = latest_info_;
    input.right_info = latest_right_info_;
    ready.push_back(input);
    waiting_.pop_front();
  }
  return ready;
}

bool WaitingImages::waitsForSensors(double now) {
  if (!options_.sensors_reach) return false;
  const Waiting& oldest = waiting_.front();
  if (options_.sensors_reach(oldest.input.image->header)) {
    gave_up_sensors_ = false;
    return false;
  }
  if (waiting_.size() > options_.capacity || now - oldest.since >= options_.sensor_patience) gave_up_sensors_ = true;
  if (!gave_up_sensors_) return true;
  if (!passed_) passed_ = {oldest.input.image->header, oldest.since};
  return false;
}

void WaitingImages::watchSensors(double now) {
  if (!passed_) return;
  const bool late = now - passed_->since >= options_.sensor_patience;
  const bool reached = options_.sensors_reach(passed_->header);
  if (reached && !late) gave_up_sensors_ = false;
  if (reached || late) passed_.reset();
}

bool WaitingImages::lacksCameraInfo(const ImageWithInfo& input) const {
  const bool left = options_.for_camera_info && !input.camera_info && !latest_info_;
  return (left || lacksRightInfo()) && !gave_up_camera_info_;
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
