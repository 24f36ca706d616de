// Whether the matches need a translation at all, or a camera that only turns explains them as well.
#pragma once

#include <cstdint>
#include <vector>

#include "gms_ransac/robust_estimator.h"
#include "judgement/judged_pose.h"

namespace gms_ransac {

/// Whose rotation is taken for the pair's.
enum class BelievedRotation : uint8_t {
  kOfPose,
  kOfEither,  ///< the pose's; as a translation is in question, it is no better known than the two agree
  kOfTurn     ///< that of the turn, which explains the matches better; no better known likewise
};

/// How far a pose explains the matches better than a turn. Statistics of Vuong's test (Econometrica 1989) on costs by
/// the geometric robust information criterion (Torr 1998), each cell of the spread grid one observation.
struct RotationVerdict {
  double against_rotation = 0;  ///< the best rotation alone
  double against_rows = 0;      ///< one that goes on while the rows of either image are read (rolling shutter)
  double still = 0;             ///< estimated share of the pose's inliers that the rotation alone leaves no parallax
  double at_infinity = 0;       ///< and of those that the pose's own rotation leaves none

  /// What speaks against a translation: kTurn, kStill or kNone.
  DirectionDoubt doubt() const;
  BelievedRotation believed() const;
  /// Whether the camera is taken to have turned and no more: a turn explains the matches better, or most of them, so
  /// that what moves beside it moves by itself.
  bool onlyTurned() const;
};

class RotationRivals {
 public:
  /// `R`: the rotation alone; `rotation_residuals`: squared transfer distance of each column under it.
  RotationVerdict compare(const JudgedPose& judged, const Eigen::Matrix3d& R,
                          const std::vector<float>& rotation_residuals);

 private:
  /// Fills costs_ of the turn with rows that fits best, by reweighted least squares.
  void fitRows(const PointColumnsView& points, const Eigen::Matrix3d& R, double variance);
  double vuong(const std::vector<int32_t>& cells);

  std::vector<float> pose_costs_, costs_;
  std::vector<double> by_cell_;
};

}  // namespace gms_ransac
