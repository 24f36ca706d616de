// Whether one part of the view asks for another pose than the rest does: a second body that has bent the pose. Derived
// in doc/uncertainty.md.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gms_ransac/robust_estimator.h"

namespace gms_ransac {

/// A rectangle of blocks of the spread grid, and the statistic of the test that the pose is the same in it and outside.
struct PoseBreak {
  static constexpr int kSide = 5;  ///< blocks to a side of the image

  double statistic = 0;  ///< chi-square with five degrees of freedom, the largest over all rectangles
  int left = 0, top = 0, right = 0, bottom = 0;  ///< blocks, the last two beyond it

  /// Drawn scenes of one rigid world, whose largest statistic is 13 in the median, exceed this in less than one of 100.
  static constexpr double kLimit = 27;
  bool found() const { return statistic > kLimit; }
  /// Whether a cell of the spread grid lies in it.
  bool holds(int32_t cell) const;
};

/// What the matches of each block of the spread grid say of the first N parameters: those of the pose, then those that
/// the camera model leaves out, which may take up what they can. With them the score test for a structural break
/// (Andrews, Econometrica 1993) over all rectangles of blocks.
template <int N>
class BlockSums {
 public:
  static constexpr int kPose = 5;
  using Whole = Eigen::Matrix<double, N, N>;
  using Parameters = Eigen::Matrix<double, N, 1>;

  void clear();
  /// A match: its cell, derivatives of its residual times the root of the loss's second derivative; 0 beyond N.
  static constexpr int kPadded = (N + 7) / 8 * 8;  ///< whole vectors
  using Derivatives = Eigen::Matrix<float, 1, kPadded>;
  void addMatch(int32_t cell, const Derivatives& derivatives);
  /// The gradients of the matches of a cell, summed.
  void addCell(int32_t cell, const Parameters& gradient);

  /// Covariance of the pose by the steps that leaving out one block after the other makes (jackknife; for clusters
  /// Bell & McCaffrey 2002). `curvature`: of all matches; `step`: that the pose lacks to the optimum. Before the test.
  Eigen::Matrix<double, kPose, kPose> jackknife(const Eigen::Matrix<double, kPose, kPose>& curvature,
                                                const Eigen::Matrix<double, kPose, 1>& step) const;

  /// The rectangles beyond the limit by the pose's own parameters, which takes little and mostly settles it. `scatter`:
  /// of the cells' gradients; `gradient`: their sum.
  void findSuspects(const Eigen::Matrix<double, kPose, kPose>& scatter, const Eigen::Matrix<double, kPose, 1>& gradient,
                    std::vector<PoseBreak>& suspects);
  /// The worst of `suspects` by all parameters. `inverse`: of the information of all matches, with what is known of the
  /// camera.
  PoseBreak worstOf(const std::vector<PoseBreak>& suspects, const Whole& inverse, const Whole& scatter,
                    const Parameters& gradient);

 private:
  using Part = Eigen::Matrix<double, kPose, N>;
  /// Of the first rows of the matrices, those of the pose.
  struct Sums {
    int count = 0;
    Part information = Part::Zero(), scatter = Part::Zero();
    Eigen::Matrix<double, kPose, 1> gradient = Eigen::Matrix<double, kPose, 1>::Zero();

    Sums& operator+=(const Sums& other);
    Sums& operator-=(const Sums& other);
  };
  template <class Value>
  using Table = std::array<std::array<Value, PoseBreak::kSide + 1>, PoseBreak::kSide + 1>;

  /// Makes the sums of each block those of all blocks above and to the left, too.
  void sumUp();
  const Sums& above(int row, int left_of) const {
    return table_[static_cast<size_t>(row)][static_cast<size_t>(left_of)];
  }
  int countWithin(const PoseBreak& region) const;
  Sums within(const PoseBreak& region) const;

  Table<Sums> table_;
  /// Of each block its information so far by rows: some hundred matches, for which single precision does.
  using BlockInformation = Eigen::Matrix<float, kPose, kPadded, Eigen::RowMajor>;
  Table<BlockInformation> information_;
};

}  // namespace gms_ransac
