// The node's parameters that are fixed at start; reconfigure.h has those that can change.
#pragma once

#include <string>
#include <vector>

#include "gms_ransac/camera.h"
#include "gms_ransac/translation_scale.h"

namespace ros {
class NodeHandle;
}

namespace gms_ransac {

enum class CameraInfoSync { kLatest, kExact };
enum class Rectified { kAuto, kYes, kNo };

enum class FeatureLayout { kVinsMono, kVinsFusion };
enum class InputKind { kStream, kPair };

/// Read once from the private namespace; the member's name is the parameter's unless stated.
struct Parameters {
  InputKind input = InputKind::kStream;  ///< stream: images of one camera | pair: two topics, compared with each other
  CameraInfoSync camera_info_sync = CameraInfoSync::kLatest;  ///< latest | exact: which camera_info goes with an image
  Rectified input_is_rectified = Rectified::kAuto;            ///< auto | true | false
  CameraIntrinsics camera;  ///< ~camera/fx fy cx cy k1 k2 p1 p2 k3: replaces camera_info when fx is given
  std::string image_transport = "raw", depth_image_transport = "raw";
  ScaleMode scale = ScaleMode::kUnit;  ///< unit | propagate | depth | fixed: length of the translations
  double fixed_scale = 1;              ///< metres of every translation with scale fixed, 1e-6..1e6
  FeatureLayout feature_layout = FeatureLayout::kVinsMono;  ///< vins_mono | vins_fusion: channels of ~features
  std::string odom_frame = "odom";                          ///< parent frame of ~odom
  std::string base_frame;                                   ///< frame that ~odom moves; empty: the camera's own
  bool invert_odom_tf = false;  ///< broadcast base -> odom, where another node owns the base frame's parent
  bool drop_frames = true;      ///< true: only the latest waiting image is kept; false: the latest `queue_size`
  int queue_size = 10;          ///< messages kept by each subscriber, and images that wait, 1..10000
  int threads = 1;  ///< 1..16; 2: the next image is extracted while this one is matched; 3, 4: either is shared by two
  double diagnostic_period = 1;   ///< seconds between messages on /diagnostics, > 0; diagnostic_updater reads it too
  bool always_subscribe = false;  ///< subscribe to the images even while nobody listens

  /// Throws std::invalid_argument with a sentence that names the parameter, its value and what is accepted.
  static Parameters read(const ros::NodeHandle& pnh);
};

/// Names set in the private namespace that neither the node knows nor its image transports: misspelt, most likely.
std::vector<std::string> unknownParameters(const ros::NodeHandle& pnh, const Parameters& parameters);

}  // namespace gms_ransac
