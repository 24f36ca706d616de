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
  RecoveryOptions recovery;
};

/// Answers images with options that do not change: a change of options is another pipeline.
struct Pipeline {
  /// Throws std::invalid_argument if the options contradict each other. `priors`: other sensors; null: none.
  Pipeline(const Parameters& at_start, const ProcessorOptions& options, std::shared_ptr<MotionPriors> priors = nullptr)
      : parameters(at_start), options(options), priors(std::move(priors)), filter(options.core) {}

  const Parameters parameters;
  const ProcessorOptions options;
  const std::shared_ptr<MotionPriors> priors;
  MatchFilter filter;
  const std::shared_ptr<FramePool> frames = std::make_shared<FramePool>();
};

/// All that the answer to the next image depends on, besides the image. Going back to an earlier image is assigning the
/// Stream of then.
struct Stream {
  std::shared_ptr<PreparedFrame> reference;  ///< what the next image is compared with; null: nothing
  Past past;
  TrackTable tracks;
  ScalePropagator scale;
  KeyFrame key;  ///< of motions with depth
  MotionIntegrator place;
  std::optional<double> stamp;  ///< of the last image, seconds; none: the next is the first

  /// The next image is compared with nothing, and the motion up to it is not known. The place stays.
  void forget() {
    reference.reset();
    past = Past();
    tracks.reset();
    scale.reset();
    key = KeyFrame();
  }
};

}  // namespace gms_ransac
