// Two bodies that move each by itself, where one pose was bent between them: found by a part of the view that asks for
// another pose than the rest. Derived in doc/inside/judgement.md.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/types.hpp>

#include "judgement/pose_covariance.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

struct RefinedPose;

/// A rectangle of blocks of the image, and the statistic of the score test for a structural break (Andrews,
/// Econometrica 1993): that the pose is the same in it and outside.
struct PoseBreak {
  double statistic = 0;  ///< chi-square with five degrees of freedom, the largest over all rectangles
  cv::Rect blocks;
  /// Standard deviation of the direction by one side alone, over that by all: of the worse side. 0 unless the view is
  /// torn: with an exact camera the statistic is larger than cameras explain in practice.
  double weaker_side = 0;

  /// Returns true if a block lies in it.
  bool holds(int block) const { return blocks.contains({block % kBlockSide, block / kBlockSide}); }
};

/// The rectangle whose matches contradict the rest most, with the camera known to its typical errors, so that an error
/// of the camera is no break. `variance`: of a residual. If the pose's own parameters show none, that by these alone.
PoseBreak findBreak(const PoseInformation& all, double variance);

/// Two motions that share the matches.
struct TwoBodies {
  TwoViewPose larger;             ///< the motion that explains more matches
  std::vector<uint8_t> of_other;  ///< of each slot: 1 where its cell follows the other motion; empty: there is none
  double smaller_share = 0;       ///< matches that the other explains, of those that the larger one does

  bool found() const { return !of_other.empty(); }
};

/// Finds a second motion. Holds nothing but storage.
class Segmentation {
 public:
  /// Refines a motion on either side of the worst break, gives every cell to the one that explains it better, and so
  /// on. Two motions are found where they explain the matches much better than the pose.
  void find(const RefinedPose& refined, TwoBodies& bodies);

 private:
  std::vector<float> residuals_[2];
  std::vector<float> second_worse_;  ///< of each cell, by how much the second motion explains it worse than the first
  PointColumns own_;
};

}  // namespace gms_ransac
