// What answers images, with options that do not change: a change of options is another pipeline.
#pragma once

#include <memory>
#include <utility>

#include "gms_ransac/match_filter.h"
#include "parameters.h"
#include "priors/motion_priors.h"
#include "stream/prepared_frame.h"
#include "stream/publishable_pose.h"
#include "stream/recovery.h"

namespace gms_ransac {

struct ProcessorOptions {
  MatchFilterOptions core;
  double max_frame_gap = 1;    ///< seconds
  bool hold_reference = true;  ///< keep the reference while the parallax is too small
  SigmaFloor sigma_floor;
  RecoveryOptions recovery;
};

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

}  // namespace gms_ransac
