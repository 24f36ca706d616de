// Whether a second body, which moves by itself, may be the world as well as the one whose motion the pose is.
#pragma once

#include <cstdint>
#include <vector>

#include "judgement/body_parting.h"
#include "judgement/judged_pose.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

class SecondBody {
 public:
  explicit SecondBody(const ResidualKernels& kernels) : kernels_(kernels) {}

  /// Whether what the pose does not explain, or what `bodies` parted from it, moves as one and is nearly as much.
  bool isRival(const JudgedPose& judged, const BodyParting& bodies, int64_t& evaluations);

 private:
  /// Fills rest_; returns how many columns the pose explains.
  int collectRest(const JudgedPose& judged);
  /// Gathers the points of the rest, and makes room.
  void takeUpRest(const PointColumnsView& points);
  /// Refines a motion on the rest and fills second_; returns how many columns it explains.
  int explainRest(TwoViewPose& motion, int64_t& evaluations);

  const ResidualKernels& kernels_;
  std::vector<int> rest_;  ///< columns that the pose does not explain
  PointColumns rest_points_;
  std::vector<TwoViewPose> motions_;
  std::vector<float> residuals_;
  std::vector<uint8_t> second_;  ///< of each column whether it is of the rest and a motion of its own explains it
};

}  // namespace gms_ransac
