// The table of the judgement: motions that the matches may come from in place of the pose, each compared with it by the
// cells of the image. Derived in doc/inside/judgement.md.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/robust_result.h"
#include "judgement/match_noise.h"
#include "judgement/pose_covariance.h"
#include "two_view/pose_model.h"
#include "two_view/two_view_points.h"

namespace gms_ransac {

/// Directions of translation that differ by more, radians, are two motions.
constexpr double kOtherDirection = 20 * M_PI / 180;

/// The comparison: the statistic of Vuong's test of non-nested models (Econometrica 1989). It is the sum over `count`
/// matches of the cost of the second model minus that of the first, over the root of the sum of squares, not centred.
/// Each cell is one observation, because its matches have correlated errors. At most the root of the number of cells.
/// `difference(i)`: of match i; `cells`: of each match.
template <class Difference>
double vuongStatistic(int count, const std::vector<int32_t>& cells, const Difference& difference) {
  std::array<double, kCellCount> by_cell = {};
  double sum = 0, squares = 0;
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const auto excess = static_cast<double>(difference(i));
    by_cell[static_cast<size_t>(cells[i])] += excess;
    sum += excess;
  }
  for (const double excess : by_cell) squares += excess * excess;
  return squares > 0 ? sum / std::sqrt(squares) : 0;
}

/// A motion that came into question besides the best one.
struct AlternativeMotion {
  TwoViewPose pose;
  bool of_plane = false;  ///< explains a plane just as well, so that chance decides which of the two fits better
};

/// A refined pose with what is known of it.
struct RefinedPose {
  const TwoViewPose& pose;
  const TwoViewPoints& points;
  PointColumnsView plausible;  ///< the points, those without weight that the noise calls implausible
  const MatchNoise& noise;     ///< at the pose
};

/// A rotation that the camera may have made where its translation is unknown.
struct Explanation {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();       ///< from reference to current
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of w in R <- exp(w) R
  double against = 0;                                    ///< vuongStatistic of the pose against it
};

/// Mean and covariance of rotations of which one is true, each as likely as the evidence for it.
Explanation togetherOf(std::initializer_list<Explanation> explanations);

/// A row of the table.
struct Candidate {
  DirectionDoubt doubt;  ///< that it raises if it stands
  double limit;          ///< of the statistic: below it the candidate stands
  double against;        ///< vuongStatistic of the pose against it
};

/// Costs are squared residuals in standard deviations, truncated. Keeps its storage.
class Candidates {
 public:
  Eigen::Matrix3d rotation;               ///< the one that explains the matches best alone, from reference to current
  std::vector<float> rotation_residuals;  ///< squared transfer distance of each column under it
  double median_parallax = 0;             ///< of the inliers, working units: the displacement that no rotation explains
  double static_share = 0;       ///< estimated share of the pose's inliers that the rotation leaves no parallax
  double share_at_infinity = 0;  ///< and of those that the pose's own rotation leaves none
  /// The rotation, the same with a rolling shutter, then motions that stand; empty if nothing was compared.
  std::vector<Candidate> table;
  PoseSquare spread;  ///< of these motions about the pose, to be added to its covariance: any of them may be true

  explicit Candidates(const ResidualKernels& kernels) : kernels_(kernels) {}

  /// Fits the rotation and empties the table. `noise`: measured at a pose with rotation `start`.
  void fitRotation(const PointColumnsView& points, const Eigen::Matrix3d& start, const MatchNoise& noise);
  /// After that: its covariance, of w in R <- exp(w) R.
  Eigen::Matrix3d rotationCovariance(const PointColumnsView& points) const;
  /// After that: compares it with the pose, alone and, unless the shutter is global, with a rolling shutter. The first
  /// two rows.
  void compareRotations(const RefinedPose& refined, bool shutter_may_roll);
  /// After that: the rotation that is known without a translation, from the pose's own (`covariance` of its rotation),
  /// the rotation alone and a rotation past a plane, which few views tell apart.
  Explanation rotationWithoutTranslation(const RefinedPose& refined, const Eigen::Matrix3d& covariance);
  /// After that: refines each of `motions` as the pose was, on a part of the matches first, and compares it.
  /// `direction_sigma`: of the pose, radians; `camera_decides`: true if plausible calibration errors could change the
  /// direction, and so whether near and far are exchanged.
  void compareMotions(const RefinedPose& refined, double direction_sigma, const std::function<bool()>& camera_decides,
                      const std::vector<AlternativeMotion>& motions);

  /// True if a candidate stands that raises this doubt.
  bool raise(DirectionDoubt doubt) const;
  /// True if a rotation explains the matches better than the pose, with rolling shutter or without.
  bool rotationIsBetter() const { return !table.empty() && std::min(table[0].against, table[1].against) < 0; }
  /// True if what shows a translation may be a body that moves by itself.
  bool mostlyStatic() const;
  /// True if the camera is taken to have only rotated: what moves besides moves by itself.
  bool onlyRotated() const;

 private:
  void countStatic(const RefinedPose& refined);
  /// The comparison with the candidate whose costs, at most `most`, are those of the first `count` matches.
  double against(const TwoViewPoints& points, int count, float most) const;
  /// Matches for each cell that has some: so many count as one observation beside a prior.
  static double matchesOfCell(const std::vector<int32_t>& cells);
  /// The rotation with rolling shutter is fitted by reweighted least squares.
  double againstRolling(const TwoViewPoints& points);
  /// So is the rotation of a camera that moves past a plane.
  Explanation pastPlane(const TwoViewPoints& points);
  /// Refines a motion on the first `count` matches and compares it there; infinite if it converged to the pose: their
  /// directions then agree to `same_within` radians.
  double againstMotion(const RefinedPose& refined, double same_within, int count, int iterations, TwoViewPose& motion);

  const ResidualKernels& kernels_;
  float per_variance_ = 1;                          ///< squared standard deviations in a squared threshold
  std::vector<float> pose_costs_, costs_, sorted_;  ///< costs_: of one candidate after the other
};

}  // namespace gms_ransac
