// Compares the rotations of pairs as images and another sensor measure them: contradictions, and what explains them.
// Knows no topic.
#pragma once

#include <deque>
#include <string>

#include <Eigen/Core>

namespace gms_ransac {

/// 99 % quantile of the squared Mahalanobis distance of two rotations, three degrees of freedom.
constexpr double kRotationChi2 = 11.34;

/// One pair, in the axes of the reference camera or of the other sensor.
struct ComparedRotation {
  double from = 0, to = 0;                               ///< seconds
  Eigen::Vector3d visual = Eigen::Vector3d::Zero();      ///< rotation vector of X_reference = R X_current
  Eigen::Vector3d prior = Eigen::Vector3d::Zero();       ///< the same as the other sensor has it
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of their difference
};

class RotationComparison {
 public:
  static constexpr size_t kPairs = 100;     ///< last ones that are compared
  static constexpr size_t kFewest = 30;     ///< before so many pairs there is no doubt
  static constexpr double kDoubtful = 0.5;  ///< share of the pairs that contradict above which something is wrong

  /// Adds a pair; it replaces one with the same start, as while the reference is held.
  void add(const ComparedRotation& pair);
  size_t pairs() const { return compared_.size(); }
  /// How many of the pairs agree with the images, in words that claim no more than that.
  std::string agreement() const;
  /// Share of the pairs whose Mahalanobis distance chance would bring once in a hundred, with the prior's axes rotated
  /// or mirrored by a matrix.
  double contradicting(const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity()) const;
  /// Returns why the two contradict each other and what to check; empty: no contradiction, or too few pairs.
  std::string doubt() const;

 private:
  /// The orthogonal matrix, prior to visual, that leaves the smallest weighted differences.
  Eigen::Matrix3d bestAxes() const;

  std::deque<ComparedRotation> compared_;
};

}  // namespace gms_ransac
