// The table of the judgement: motions that the matches may come from in place of the pose, each compared with it by the
// cells of the image. Costs are squared residuals in standard deviations, truncated. Derived in
// doc/inside/judgement.md.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "judgement/pose_covariance.h"
#include "judgement/refined_pose.h"

namespace gms_ransac {

/// Directions of translation that differ by more, radians, are two motions.
constexpr double kOtherDirection = 20 * M_PI / 180;

/// The comparison: the statistic of Vuong's test of non-nested models (Econometrica 1989). It is the sum over `count`
/// matches of the cost of the second model minus that of the first, over the root of the sum of squares, not centred.
/// Each cell is one observation, because its matches have correlated errors. At most the root of the number of cells.
/// `difference(i)`, cells[i]: of match i, a row or a slot.
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

/// The rotation that explains the matches best by itself. Keeps its storage.
struct RotationAlone {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< from reference to current
  std::vector<float> residuals;                     ///< squared transfer distance of each slot
  std::vector<float> parallaxes;  ///< of the pose's inliers, working units: the displacements that it leaves, unsorted
  double median_parallax = 0;
};

/// A rotation that the camera may have made where its translation is unknown.
struct Explanation {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();       ///< from reference to current
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of w in R <- exp(w) R
  double against = 0;                                    ///< vuongStatistic of the pose against it
};

/// Mean and covariance of rotations of which one is true, each as likely as the evidence for it.
Explanation togetherOf(std::initializer_list<Explanation> explanations);

/// The rows of the table.
struct Verdict {
  /// vuongStatistic of the pose against the rotation alone, and against it with a rolling shutter.
  double rotation = std::numeric_limits<double>::infinity(), rolling = std::numeric_limits<double>::infinity();
  double other_motion = 3;                 ///< least statistic of the pose against another direction, over its limit
  PoseSquare spread = PoseSquare::Zero();  ///< of the motions that do, about the pose: any of them may be true
  double static_share = 0;       ///< estimated share of the pose's inliers that the rotation alone leaves no parallax
  double share_at_infinity = 0;  ///< and of those that the pose's own rotation leaves none

  /// True if one explains them better.
  bool rotationIsBetter() const { return std::min(rotation, rolling) < 0; }
  /// True if the camera is taken to have only rotated: what moves besides moves by itself.
  bool onlyRotated() const;
};

/// Fits the rotation, from that of the pose.
void fitRotation(const RefinedPose& refined, RotationAlone& alone);
/// Its covariance, of w in R <- exp(w) R.
Eigen::Matrix3d rotationCovariance(const PoseModel& model, const Eigen::Matrix3d& R);
/// Compares it with the pose, alone and, unless the shutter is global, with a rolling shutter.
Verdict compareRotations(const RefinedPose& refined, const RotationAlone& alone, bool shutter_may_roll);
/// Refines each of `motions` as the pose was, on a part of the matches first, compares it with the pose, and adds it to
/// the verdict. `direction_sigma`: of the pose, radians. `storage`: of residuals.
void compareMotions(const RefinedPose& refined, double direction_sigma, const std::vector<AlternativeMotion>& motions,
                    std::vector<float>& storage, Verdict& verdict);
/// The rotation that is known without a translation, from the pose's own, the rotation alone and a rotation past a
/// plane, which few views tell apart.
Explanation rotationWithoutTranslation(const RefinedPose& refined, const RotationAlone& alone, const Verdict& verdict);

}  // namespace gms_ransac
