// The relative pose of a comparison -> the pose that is published: the length of its translation by ~scale, its
// least covariance, and the last look at it.
#pragma once

#include <memory>
#include <utility>

#include "parameters.h"
#include "priors/motion_priors.h"
#include "scale/translation_scale.h"
#include "stream/processed_frame.h"
#include "stream/publishable_pose.h"

namespace gms_ransac {

class PairPose {
 public:
  /// `priors`: other sensors; null: none.
  PairPose(const Parameters& parameters, std::shared_ptr<MotionPriors> priors);

  /// Fills the pose and its length from `reference`, `current`, `result`, `status`, `text` and `recovered`. Depth may
  /// change LOW_PARALLAX to OK; a pose that is unfit to publish becomes RANSAC_FAILED with the reason.
  void finish(const SigmaFloor& floor, ProcessedFrame& processed);
  /// The current image of the last pair becomes the reference of the next.
  void advance();
  /// The next pair follows on none.
  void reset();

  /// Scale state of the reference, to continue from later.
  const ScalePropagator& scale() const { return propagator_; }
  void goOnFrom(ScalePropagator scale) { propagator_ = std::move(scale); }

 private:
  /// By ~scale.
  void findLength(ProcessedFrame& processed);
  /// In units of the first pair's.
  void propagate(ProcessedFrame& processed);
  /// Length from odometry or the ground, or why there is none.
  void askPriors(ProcessedFrame& processed);
  /// Metric pose from depth or a second camera, or why there is none.
  void takeDepth(ProcessedFrame& processed);

  const Parameters parameters_;
  const std::shared_ptr<MotionPriors> priors_;
  ScalePropagator propagator_;
  Triangulation triangulation_;
  bool scale_updated_ = false;  ///< the propagator knows the features of the last pair
};

}  // namespace gms_ransac
