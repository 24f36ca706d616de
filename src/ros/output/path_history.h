// The poses of ~path: all of a journey, however long, in bounded memory.
#pragma once

#include <cstddef>
#include <vector>

#include <geometry_msgs/PoseStamped.h>

namespace gms_ransac {

/// Every pose at first; whenever there is no more room every second one goes, so that what stays is evenly spread.
class PathHistory {
 public:
  /// `capacity`: poses kept at most; even.
  explicit PathHistory(size_t capacity) : capacity_(capacity) {}

  void add(const geometry_msgs::PoseStamped& pose);
  void clear();
  /// In the order they were added; the first and the last one are always among them.
  const std::vector<geometry_msgs::PoseStamped>& poses() const { return poses_; }

 private:
  void thin();

  const size_t capacity_;
  size_t stride_ = 1;  ///< every so many-th pose stays
  size_t added_ = 0;
  std::vector<geometry_msgs::PoseStamped> poses_;
};

}  // namespace gms_ransac
