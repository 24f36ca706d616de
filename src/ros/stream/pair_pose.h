// The relative pose of a comparison -> the pose that is published: the length of its translation as ~scale says, its
// least covariance, and the last look at it.
#pragma once

#include <memory>
#include <utility>

#include "gms_ransac/translation_scale.h"
#include "parameters.h"
#include "priors/motion_priors.h"
#include "stream/processed_frame.h"
#include "stream/publishable_pose.h"

namespace gms_ransac {

class PairPose {
 public:
  /// `priors`: other sensors to ask; null: none.
  PairPose(const Parameters& parameters, std::shared_ptr<MotionPriors> priors);

  /// Fills what is said of the pose, from `reference`, `current`, `result`, `status`, `text` and `recovered`, which are
  /// set. Depth may make an answer of LOW_PARALLAX one that is OK; a pose that is not fit to publish becomes
  /// RANSAC_FAILED, with what is wrong with it.
  void finish(const SigmaFloor& floor, ProcessedFrame& processed);
  /// The current image of the last pair becomes the reference of the next.
  void advance();
  /// The next pair follows on none.
  void reset();

  /// What is known of the reference's scale, to go on from later.
  const ScalePropagator& scale() const { return propagator_; }
  void goOnFrom(ScalePropagator scale) { propagator_ = std::move(scale); }

 private:
  /// As ~scale asks.
  void findLength(ProcessedFrame& processed);
  /// In units of the first pair's.
  void propagate(ProcessedFrame& processed);
  /// What other sensors or the ground tell; says why they tell none.
  void askPriors(ProcessedFrame& processed);
  /// The metric pose of depth or of a second camera, where enough is known; says why not where it is not.
  void takeDepth(ProcessedFrame& processed);
  void stopIfUnfit(ProcessedFrame& processed);

  const Parameters parameters_;
  const std::shared_ptr<MotionPriors> priors_;
  ScalePropagator propagator_;
  Triangulation triangulation_;
  bool scale_updated_ = false;  ///< the propagator knows the features of the last pair
};

}  // namespace gms_ransac
