// Two bodies that move each by itself, where one pose was bent between them. Derived in doc/uncertainty.md.
#pragma once

#include <cstdint>
#include <vector>

#include "judgement/judged_pose.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

class BodyParting {
 public:
  explicit BodyParting(const ResidualKernels& kernels) : kernels_(kernels) {}

  /// Takes up a pair.
  void begin() { found_ = false; }
  /// From the two sides of a break, each refined by itself; then every cell of the spread grid goes to the motion that
  /// explains it better, and so on. Found are two bodies where they explain the matches much better than the one pose
  /// did.
  void part(const JudgedPose& judged, int64_t& evaluations);
  /// That there are two in this pair.
  bool found() const { return found_; }
  /// Where there are: the motion of the larger one.
  const TwoViewPose& larger() const { return bodies_[0]; }
  /// Of each column whether it is the smaller one's, and how many that explains for one of the larger's.
  const std::vector<uint8_t>& apart() const { return apart_; }
  double smallerShare() const { return smaller_share_; }

 private:
  /// Refines each body on its own matches and finds what it leaves of all.
  void refine(const PointColumnsView& points, int64_t& evaluations);
  /// Gives each cell to one of them.
  void assign(const std::vector<int32_t>& cells);

  const ResidualKernels& kernels_;
  TwoViewPose bodies_[2];
  std::vector<float> residuals_[2];
  std::vector<uint8_t> apart_;       ///< which body a column is of
  std::vector<float> second_worse_;  ///< of each cell, by how much the second body explains it worse than the first
  std::vector<int> columns_;
  PointColumns own_;
  double smaller_share_ = 0;
  bool found_ = false;
};

}  // namespace gms_ransac
