#include "output/path_history.h"

namespace gms_ransac {

void PathHistory::add(const geometry_msgs::PoseStamped& pose) {
  const bool last_stays = added_ == 0 || (added_ - 1) % stride_ == 0;
  if (!last_stays) {
    poses_.back() = pose;
  } else {
    if (poses_.size() == capacity_) thin();
    poses_.push_back(pose);
  }
  ++added_;
}

void PathHistory::thin() {
  for (size_t i = 0; 2 * i < poses_.size(); ++i) poses_[i] = poses_[2 * i];
  poses_.resize(poses_.size() / 2);
  stride_ *= 2;
}

void PathHistory::clear() {
  poses_.clear();
  stride_ = 1;
  added_ = 0;
}

}  // namespace gms_ransac
