// The methods of the literature and of the paper: one RANSAC loop over an ordering, a sampler and a verifier.
#pragma once

#include <memory>
#include <vector>

#include "gms_ransac/robust_estimator.h"
#include "pose/pose_recovery.h"
#include "robust/acceptance.h"
#include "robust/ordering.h"
#include "robust/sampler.h"
#include "robust/two_view_problem.h"
#include "robust/verifier.h"

namespace gms_ransac {

class RansacEstimator : public RobustEstimator {
 public:
  RansacEstimator(const Method& method, const RobustOptions& options);
  void estimate(const PointPairs& pairs, const Camera& camera, RobustResult& result) override;
  void setSeed(uint64_t seed) override { options_.seed = seed; }

 private:
  struct Hypothesis {
    Eigen::Matrix3d model = Eigen::Matrix3d::Zero();
    Support support;
  };
  /// The RANSAC loop: the best-supported hypothesis on `points`; its support is zero when there is none. `cost` counts.
  Hypothesis search(const OrderedPoints& points, int max_iterations, RobustResult& cost);
  /// RANSAC inside random subsets, the winner being the best on all points.
  Hypothesis searchSubsets(const OrderedPoints& points, RobustResult& cost);
  bool refines() const;
  /// A fundamental matrix or homography after robust least squares, if that is asked for.
  Eigen::Matrix3d refined(const Eigen::Matrix3d& model, RobustResult& cost);
  /// Final mask, acceptance and pose, with the refinement of an essential matrix.
  void conclude(const PointPairs& pairs, const Camera& camera, RobustResult& result);

  Method method_;
  RobustOptions options_;
  QualityKey quality_key_;
  std::unique_ptr<Sampler> sampler_;
  Verifier verifier_;
  InlierCounter all_points_;  ///< judges the winners of random subsets, refines the final model
  InlierCounter marker_;      ///< tells the sampler which matches the best hypothesis explains
  Ordering ordering_;
  TwoViewProblem problem_;
  Acceptance acceptance_;
  PoseRecovery pose_recovery_;
  Random random_;
  std::vector<int> order_, subset_order_, arrangement_;
  OrderedPoints points_, subset_, arranged_;
  std::vector<uint8_t> inlier_;  ///< of the best hypothesis, in order
};

}  // namespace gms_ransac
