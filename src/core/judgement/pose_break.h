// Whether one part of the view asks for another pose than the rest does: a second body that has bent the pose. Derived
// in doc/uncertainty.md.
#pragma once

#include <array>
#include <cstdint>

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

/// Score test for a structural break (Andrews, Econometrica 1993) over all rectangles of blocks. Parameters: of the
/// pose, then those that the camera model leaves out, which may take up what they can.
class PoseBreakTest {
 public:
  static constexpr int kPose = 5, kAll = 15;
  using Part = Eigen::Matrix<double, kPose, kAll>;
  using Whole = Eigen::Matrix<double, kAll, kAll>;
  using Parameters = Eigen::Matrix<double, kAll, 1>;

  void clear();
  /// A match: its cell, derivatives of its residual times the root of the loss's second derivative.
  void addMatch(int32_t cell, const Eigen::Matrix<float, kAll, 1>& derivatives);
  /// The gradients of the matches of a cell, summed.
  void addCell(int32_t cell, const Parameters& gradient);

  /// Covariance of the pose by the steps that leaving out one block after the other makes (jackknife; for clusters
  /// Bell & McCaffrey 2002). `curvature`: of all matches; `step`: that the pose lacks to the optimum. Before find().
  Eigen::Matrix<double, kPose, kPose> jackknife(const Eigen::Matrix<double, kPose, kPose>& curvature,
                                                const Eigen::Matrix<double, kPose, 1>& step) const;

  /// `inverse`: of the information of all matches, with what is known of the camera; `scatter`: of the cells'
  /// gradients; `gradient`: their sum.
  PoseBreak find(const Whole& inverse, const Whole& scatter, const Parameters& gradient);

 private:
  /// Sums over blocks, of the first rows of the matrices: those of the pose.
  struct Sums {
    int count = 0;
    Part information = Part::Zero(), scatter = Part::Zero();
    Eigen::Matrix<double, kPose, 1> gradient = Eigen::Matrix<double, kPose, 1>::Zero();

    Sums& operator+=(const Sums& other);
    Sums& operator-=(const Sums& other);
  };
  template <class Value>
  using Table = std::array<std::array<Value, PoseBreak::kSide + 1>, PoseBreak::kSide + 1>;

  void sumUp();
  /// Over the blocks of a rectangle: what `take` returns of their sums.
  template <class Value, class Take>
  Value within(const PoseBreak& region, const Take& take) const;
  template <int N>
  double statisticOf(const PoseBreak& region, const Eigen::Matrix<double, N, N>& inverse,
                     const Eigen::Matrix<double, N, N>& spread, const Eigen::Matrix<double, N, 1>& step) const;

  Table<Sums> table_;  ///< of blocks; after sumUp of all blocks above and to the left
  /// Of each block its information so far: some hundred matches, for which single precision does.
  Table<Eigen::Matrix<float, kPose, kAll>> information_;
};

}  // namespace gms_ransac
