// The stream as a value, and the pipeline that answers its images.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "gms_ransac/match_filter.h"
#include "gms_ransac/past.h"
#include "parameters.h"
#include "priors/motion_priors.h"
#include "scale/depth_pose.h"
#include "stream/odometry.h"
#include "stream/pair_pose.h"
#include "stream/prepared_frame.h"
#include "tracks/track_table.h"

namespace gms_ransac {

struct RecoveryOptions {
  int frames = 0;       ///< that are kept; 0: a loss is final
  double seconds = 10;  ///< age at which a kept image is dropped
};

struct ProcessorOptions {
  MatchFilterOptions core;
  double max_frame_gap = 1;    ///< seconds
  bool hold_reference = true;  ///< keep the reference while the parallax is too small
  SigmaFloor sigma_floor;
  double systematic_sigma = 0.003;  ///< share of each motion that is wrong alike in all pairs (sharedErrors)
  RecoveryOptions recovery;
};

/// The core with its options, and frames for them.
struct Core {
  /// Throws std::invalid_argument if the options contradict each other.
  explicit Core(const MatchFilterOptions& options) : filter(options) {}

  MatchFilter filter;
  const std::shared_ptr<FramePool> frames = std::make_shared<FramePool>();
};

/// Answers images with options that do not change: a change of options is another pipeline.
struct Pipeline {
  /// `priors`: other sensors; null: none.
  Pipeline(const Parameters& at_start, const ProcessorOptions& options, std::shared_ptr<Core> core,
           std::shared_ptr<MotionPriors> priors = nullptr)
      : parameters(at_start),
        options(options),
        priors(std::move(priors)),
        core(std::move(core)),
        filter(this->core->filter) {}
  /// Throws std::invalid_argument if the options contradict each other.
  Pipeline(const Parameters& at_start, const ProcessorOptions& options, std::shared_ptr<MotionPriors> priors = nullptr)
      : Pipeline(at_start, options, std::make_shared<Core>(options.core), std::move(priors)) {}

  const Parameters parameters;
  const ProcessorOptions options;
  const std::shared_ptr<MotionPriors> priors;
  const std::shared_ptr<Core> core;  ///< shared with other pipelines whose options of the core are the same
  MatchFilter& filter;
};

/// All that the answer to the next image depends on, besides the image. Going back to an earlier image is assigning the
/// Stream of then.
struct Stream {
  std::shared_ptr<PreparedFrame> reference;  ///< what the next image is compared with; null: nothing
  Past past;
  TrackTable tracks;
  ScalePropagator scale;
  KeyFrame key;  ///< of motions with depth
  LearntRig rig;
  LearntOffset offset;
  std::pair<std::shared_ptr<const CameraModel>, std::shared_ptr<const CameraModel>> cameras;  ///< of `rig` or `offset`
  MotionIntegrator place;
  std::optional<double> stamp;  ///< of the last image, seconds; none: the next is the first
  double copied_seconds = 0;    ///< since the reference, in which copies came: they show that the stream goes on

  /// Another calibration has other errors.
  void useCameras(const decltype(cameras)& left_and_right) {
    if (cameras != left_and_right) forgetSensor();
    cameras = left_and_right;
  }
  void forgetSensor() {
    rig = LearntRig();
    offset = LearntOffset();
  }
  /// The next pair continues no other. Mask and shutter of the camera stay.
  void breakChain() { past.reference_image = past.current_image = 0; }
  /// The next image is compared with nothing, and the motion up to it is not known. The place stays.
  void forget() {
    reference.reset();
    copied_seconds = 0;
    breakChain();
    tracks.reset();
    scale.reset();
    key = KeyFrame();
  }
};

}  // namespace gms_ransac
