#include "waiting_images.h"

namespace gms_ransac {

void WaitingImages::add(const ImageWithInfo& input, double now) { waiting_.push_back({input, now}); }

void WaitingImages::setCameraInfo(const sensor_msgs::CameraInfoConstPtr& info) { latest_info_ = info; }

std::vector<ImageWithInfo> WaitingImages::settled(double now) {
  std::vector<ImageWithInfo> ready;
  while (!waiting_.empty()) {
    ImageWithInfo& input = waiting_.front().input;
    if (lacksCameraInfo(input)) {
      if (!overdue(now)) break;
      gave_up_camera_info_ = true;
    }
    if (!input.camera_info) input.camera_info = latest_info_;
    ready.push_back(input);
    waiting_.pop_front();
  }
  return ready;
}

bool WaitingImages::lacksCameraInfo(const ImageWithInfo& input) const {
  return options_.for_camera_info && !gave_up_camera_info_ && !input.camera_info && !latest_info_;
}

bool WaitingImages::overdue(double now) const {
  return waiting_.size() > options_.capacity || now - waiting_.front().since >= options_.patience;
}

}  // namespace gms_ransac
