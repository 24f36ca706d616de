// Chooses once among the optima that a search came across, by the costs of all matches
// (doc/inside/estimator.md).
#pragma once

#include <vector>

#include "judgement/candidates.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

/// Compares the optimum of a search with those that it may have missed. Keeps its storage.
class Optima {
 public:
  /// The motions that the last choice was among, for PoseJudge to compare the chosen one with.
  std::vector<AlternativeMotion> alternatives;

  explicit Optima(const ResidualKernels& kernels) : kernels_(kernels) {}

  /// Returns the likeliest optimum: `found`, those near `starts`, the other motion of a plane that most matches lie on,
  /// or that of the far half of the matches. A body that moves by itself is mostly near.
  TwoViewPose choose(const TwoViewPoints& points, const TwoViewPose& found, const std::vector<TwoViewPose>& starts);

 private:
  struct Optimum {
    TwoViewPose pose;
    bool of_plane;
    float cost;
  };

  /// Measures the noise of the matches that a motion explains, and the median of their parallaxes.
  void measure(const PoseModel& model, const TwoViewPose& found);
  /// Fills optima_ with all but `found`, not refined.
  void propose(const PoseModel& model, const TwoViewPose& found, const std::vector<TwoViewPose>& starts);
  /// Returns the sum of the squared residuals in deviations of the noise, each at most kMostCost.
  float costOf(const PoseModel& model, const TwoViewPose& pose);

  const ResidualKernels& kernels_;
  float per_variance_ = 1;     ///< squared deviations of the noise in a squared threshold
  float median_parallax_ = 0;  ///< squared, thresholds
  std::vector<float> residuals_, parallaxes_, sorted_;
  PointColumns far_;
  std::vector<Optimum> optima_;
};

}  // namespace gms_ransac
