// The node's parameters that are fixed at start; node/read_parameters.h reads them, and has those that can change.
#pragma once

#include <string>

#include "camera/camera_info.h"
#include "gms_ransac/camera.h"
#include "scale/translation_scale.h"

namespace gms_ransac {

enum class CameraInfoSync { kLatest, kExact };
enum class MaskSync { kLatest, kExact };

enum class FeatureLayout { kVinsMono, kVinsFusion, kLviSam };
enum class OverlayColour { kResidual, kProbability, kTrack, kDepth, kStage };
enum class OverlayLayout { kFlow, kSideBySide };
enum class InputKind { kStream, kPair, kStereo, kKeypoints };
enum class RotationPriorKind { kNone, kImu, kTf, kOdom };

/// cfg/parameters.py has the meaning, range and default of each.
struct Parameters {
  std::string name;  ///< of the node, the prefix of its log lines
  InputKind input = InputKind::kStream;
  CameraInfoSync camera_info_sync = CameraInfoSync::kLatest;
  Rectified input_is_rectified = Rectified::kAuto;
  CameraIntrinsics camera;  ///< replaces camera_info when fx is given
  std::string image_transport = "raw", depth_image_transport = "raw";
  std::string mask_file;  ///< empty: none
  MaskSync mask_sync = MaskSync::kLatest;
  ScaleMode scale = ScaleMode::kUnit;
  double fixed_scale = 1;
  double camera_height = 0;  ///< metres above the ground; 0: not known
  RotationPriorKind rotation_prior = RotationPriorKind::kNone;
  std::string imu_frame, prior_frame;  ///< empty: that of the messages; none
  double image_time_offset = 0;        ///< seconds
  FeatureLayout feature_layout = FeatureLayout::kVinsMono;
  std::string stereo_features_type = "gms_ransac/StereoFeatures";
  std::string odom_frame = "odom", base_frame;
  bool invert_odom_tf = false, drop_frames = true, always_subscribe = false;
  bool publish_uncertain = false;
  int queue_size = 10, threads = 1;
  double diagnostic_period = 1;  ///< diagnostic_updater reads it, too

  /// Depth images or a second camera measure metres.
  bool measuresDepth() const { return scale == ScaleMode::kDepth || input == InputKind::kStereo; }
  /// Each pair has a length of its own, or none.
  bool measuresMetres() const { return measuresDepth() || gms_ransac::measuresMetres(scale); }
  bool givesMetres() const { return measuresMetres() || scale == ScaleMode::kFixed; }

  /// Another sensor measures rotations or lengths.
  bool usesSensors() const {
    return rotation_prior != RotationPriorKind::kNone || scale == ScaleMode::kOdometry || scale == ScaleMode::kGround;
  }
};

}  // namespace gms_ransac
