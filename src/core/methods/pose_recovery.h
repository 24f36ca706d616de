// From a two-view model and its inliers to the relative pose, and whether the pair can tell it.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/camera.h"
#include "gms_ransac/point_pairs.h"
#include "gms_ransac/robust_options.h"
#include "gms_ransac/robust_result.h"
#include "judgement/pose_judge.h"
#include "two_view/kernels/residual_kernels.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

struct RecoveredPose {
  const Judgement* judgement = nullptr;  ///< null: there is no pose; valid until the next call
  std::optional<Eigen::Matrix3d> model;  ///< the essential matrix, where the pose has moved from that of the model
};

class PoseRecovery {
 public:
  explicit PoseRecovery(const RobustOptions& options)
      : options_(options), kernels_(residualKernels(options.simd)), judge_(options) {}
  /// The pose of result.model, and its judgement, by model_type and inlier. PoseJudge compares it with the motions of
  /// findMotionStarts and, if the matches lie on a plane, with its other motion. Among the poses that a model allows,
  /// the one with most inliers in front of both cameras wins; among the two motions of a plane the likelier. `refine`:
  /// a pose of an essential or a fundamental matrix moves to the robust optimum over the matches near it, and an
  /// essential matrix follows. A plane leaves a fundamental matrix undetermined, so its optimum may be another one that
  /// explains the matches better. There is none without a calibration. A homography of a pure rotation gives a zero
  /// translation. `points`: what the model was found in, which are looked at again where they are normalised.
  RecoveredPose recover(const PointPairs& pairs, const Camera& camera, const TwoViewPoints& points,
                        const RobustResult& result, bool refine);

 private:
  /// A motion that the model allows.
  struct Motion {
    TwoViewPose pose;  ///< t may be zero
    int in_front = 0;  ///< inliers in front of both cameras
  };
  /// A motion as an explanation of all matches.
  struct Explanation {
    TwoViewPose optimum;
    float cost;
  };
  void collectInliers(const PointPairs& pairs, const Eigen::Matrix3d& K, const std::vector<uint8_t>& inlier);
  /// Fills `candidates_` with the motions that the result's model allows.
  void propose(const PointPairs& pairs, const Camera& camera, const RobustResult& result);
  void proposeFromEssential(const Eigen::Matrix3d& E);
  void proposeFromHomography(const Eigen::Matrix3d& H, const Eigen::Matrix3d& K);
  void propose(const TwoViewPose& pose);
  int countInFront(const TwoViewPose& motion) const;
  /// Without `refine` the pose counts as its own optimum.
  Explanation explain(const PointColumnsView& points, const TwoViewPose& pose, bool refine) const;
  /// Fills `alternatives_` with what the pose is compared with: starts; motions of a homography that have enough
  /// inliers in front; both motions of a plane that most matches lie on. The likeliest that the model allows becomes
  /// `chosen`.
  void weighAlternatives(const PointColumnsView& points, int most_in_front, bool refine, ModelType type,
                         Explanation& chosen);

  RobustOptions options_;
  const ResidualKernels& kernels_;
  PoseJudge judge_;
  std::vector<Eigen::Vector3d> reference_, current_;  ///< inliers on the normalised image plane (z = 1)
  std::vector<Motion> candidates_;
  TwoViewPoints normalized_;  ///< where the model was found in other coordinates
  std::vector<float> residuals_;
  std::vector<TwoViewPose> starts_;
  std::vector<AlternativeMotion> alternatives_;
};

}  // namespace gms_ransac
