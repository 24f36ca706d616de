// The node's parameters: those fixed at start (listed here) and those that can change (listed in cfg/MatchFilter.cfg).
#pragma once

#include <string>
#include <vector>

#include <gms_ransac/MatchFilterConfig.h>
#include <ros/node_handle.h>

#include "gms_ransac/camera.h"
#include "gms_ransac/match_filter.h"
#include "gms_ransac/translation_scale.h"

namespace gms_ransac {

enum class CameraInfoSync { kLatest, kExact };
enum class MaskSync { kLatest, kExact };
enum class Rectified { kAuto, kYes, kNo };

enum class FeatureLayout { kVinsMono, kVinsFusion };
enum class InputKind { kStream, kPair };

/// Read once from the private namespace; the member's name is the parameter's unless stated.
struct Parameters {
  InputKind input = InputKind::kStream;  ///< stream: images of one camera | pair: two topics, compared with each other
  CameraInfoSync camera_info_sync = CameraInfoSync::kLatest;  ///< latest | exact: which camera_info goes with an image
  Rectified input_is_rectified = Rectified::kAuto;            ///< auto | true | false
  CameraIntrinsics camera;  ///< ~camera/fx fy cx cy k1 k2 p1 p2 k3: replaces camera_info when fx is given
  std::string mask_file;    ///< image whose zeros are masked until one comes on ~mask; empty: none
  MaskSync mask_sync = MaskSync::kLatest;  ///< latest | exact: which ~mask goes with an image
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

/// Checks the start values of the reconfigurable parameters, which dynamic_reconfigure would silently clamp. Throws
/// std::invalid_argument like Parameters::read.
void checkConfigOnServer(const ros::NodeHandle& pnh);

/// What dynamic_reconfigure is given for MatchFilterConfig. It brings a number out of its range to the nearest one
/// allowed without a word; here nothing is changed, and `problem` says what was asked for, so that it can be refused.
struct UnclampedConfig : MatchFilterConfig {
  UnclampedConfig() = default;
  UnclampedConfig(const MatchFilterConfig& config) : MatchFilterConfig(config) {}  // implicit: the server converts so
  /// Hides the one that dynamic_reconfigure generates; its server calls it with every request.
  void __clamp__();

  std::vector<std::string> renamed;  ///< a sentence for each earlier name of a method or extractor, already replaced
  std::string problem;  ///< names every number out of range and every unknown word, and what is accepted; empty: none
};

/// The core's options from the reconfigurable parameters; throws std::invalid_argument when they contradict each other.
MatchFilterOptions coreOptions(const MatchFilterConfig& config);

/// Names set in the private namespace that neither the node knows nor its image transports: misspelt, most likely.
std::vector<std::string> unknownParameters(const ros::NodeHandle& pnh, const Parameters& parameters);

}  // namespace gms_ransac
