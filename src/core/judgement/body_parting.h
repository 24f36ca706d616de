// Two bodies that move each by itself, where one pose was bent between them. Derived in doc/uncertainty.md.
#pragma once

#include <cstdint>
#include <vector>

#include "judgement/pose_break.h"
#include "two_view/pose_model.h"

namespace gms_ransac {

class BodyParting {
 public:
  /// Takes up a pair.
  void begin() { found_ = false; }
  /// From the two sides of a break, each refined by itself; then every cell of the spread grid goes to the motion that
  /// explains it better, and so on. Found are two bodies where they explain the matches much better than the one pose
  /// did. `residuals`: of the columns under that pose; `pose` becomes the motion of the larger body.
  void part(const ResidualKernels& kernels, const PointColumnsView& points, const std::vector<int32_t>& cells,
            const PoseBreak& pose_break, const std::vector<float>& residuals, TwoViewPose& pose, int64_t& evaluations);
  /// That there are two in this pair.
  bool found() const { return found_; }
  /// Where there are: of each column whether it is the smaller body's, and how many that explains for one of the
  /// larger's.
  const std::vector<uint8_t>& apart() const { return apart_; }
  double smallerShare() const { return smaller_share_; }

 private:
  /// Refines each body on its own matches and finds what it leaves of all.
  void refine(const ResidualKernels& kernels, const PointColumnsView& points, int64_t& evaluations);
  /// Gives each cell to one of them.
  void assign(const std::vector<int32_t>& cells);

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
