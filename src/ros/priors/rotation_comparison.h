// Compares the rotations of pairs as images and another sensor measure them: contradictions, and what explains them.
// Knows no topic.
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>

#include <Eigen/Core>

namespace gms_ransac {

/// 99 % quantile of the squared Mahalanobis distance of two rotations, three degrees of freedom.
constexpr double kRotationChi2 = 11.34;

/// One pair, in the axes of the reference camera or of the other sensor.
struct ComparedRotation {
  double from = 0, to = 0;                               ///< seconds, on the clock of the other sensor
  Eigen::Vector3d visual = Eigen::Vector3d::Zero();      ///< rotation vector of X_reference = R X_current
  Eigen::Vector3d prior = Eigen::Vector3d::Zero();       ///< the same as the other sensor has it
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of their difference
};

/// Correction of the image stamps, in addition to ~image_time_offset, that makes both agree.
struct TimeOffset {
  double seconds = 0, sigma = 0;
  bool explains = false;  ///< with it most pairs do not contradict any more
};

class RotationComparison {
 public:
  /// The other sensor's rotation vector between two times; none where it does not know.
  using RotationBetween = std::function<std::optional<Eigen::Vector3d>(double from, double to)>;

  static constexpr size_t kPairs = 100;          ///< last ones that are compared
  static constexpr size_t kFewest = 30;          ///< before so many pairs there is no doubt
  static constexpr double kDoubtful = 0.5;       ///< share of the pairs that contradict above which something is wrong
  static constexpr double kLargestOffset = 0.2;  ///< seconds either way that are searched

  /// Adds a pair; it replaces one with the same start, as while the reference is held.
  void add(const ComparedRotation& pair);
  size_t pairs() const { return compared_.size(); }
  /// How many of the pairs agree with the images, in words that claim no more than that.
  std::string agreement() const;
  /// Share of the pairs whose Mahalanobis distance chance would bring once in a hundred, with the prior's axes rotated
  /// or mirrored by a matrix.
  double contradicting(const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity()) const;
  /// The shift that leaves the least robust squares of rotations, less a constant rate, the bias. None if the rotation
  /// is too small or too even to determine it. Asks for hundreds of rotations: a matter of milliseconds.
  std::optional<TimeOffset> timeOffset(const RotationBetween& prior) const;
  /// Returns why the two contradict each other and what to check; empty: no contradiction, or too few pairs. `offset`:
  /// the result of timeOffset().
  std::string doubt(const std::optional<TimeOffset>& offset) const;

 private:
  /// The robust squares at one shift.
  struct Fit {
    double cost;  ///< infinite where less than half of the pairs have a prior
    size_t pairs, contradicting;
  };
  Fit fit(const RotationBetween& prior, double shift) const;
  /// The orthogonal matrix, prior to visual, that leaves the smallest weighted differences.
  Eigen::Matrix3d bestAxes() const;

  std::deque<ComparedRotation> compared_;
};

}  // namespace gms_ransac
