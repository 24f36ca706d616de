// Lookups of sensor poses in tf: one listener, and an answer or a sentence instead of exceptions.
#pragma once

#include <memory>
#include <string>

#include <Eigen/Geometry>

namespace ros {
class NodeHandle;
}
namespace tf2_ros {
class Buffer;
class TransformListener;
}  // namespace tf2_ros

namespace gms_ransac {

class TfLookup {
 public:
  explicit TfLookup(const ros::NodeHandle& nh);
  ~TfLookup();

  /// X_target = transform X_source at a time, 0 for the latest that is known. Returns an empty string, or what tf says
  /// is missing. Frames that are the same need no tf.
  std::string get(const std::string& target, const std::string& source, double stamp, Eigen::Isometry3d& transform);
  /// Forgets all but static transforms.
  void clear();

 private:
  std::unique_ptr<tf2_ros::Buffer> buffer_;
  std::unique_ptr<tf2_ros::TransformListener> listener_;
};

}  // namespace gms_ransac
