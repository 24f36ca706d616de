// How far the truth of a data set may be from what its images saw.
#pragma once

#include <Eigen/Geometry>

#include "datasets/dataset.h"

namespace gms_ransac {

/// Of a data set's true motion from image to image: standard deviations for each axis. doc/trust.md tells what they are
/// for which kind of set.
struct TruthNoise {
  double rotation = 0;     ///< radians
  double translation = 0;  ///< metres
  double clock = 0;        ///< seconds, that the images' stamps are off the truth's, all alike
  double alignment = 0;    ///< radians, that the axes of the truth are turned against those of the camera

  /// The truth is that of the drawing itself.
  bool exact() const { return rotation == 0 && translation == 0 && clock == 0 && alignment == 0; }
};

/// What a clock that is off by one standard deviation does to the true motion of a pair.
struct ClockStep {
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rotation vector, radians
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< metres
};

/// Nothing where the truth is not known around both frames.
ClockStep clockStep(const Dataset& dataset, const DatasetPair& pair, double clock);

/// The same for one pair, as covariances of its true motion (current_in_reference) in the reference frame.
struct PairNoise {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();     ///< of the rotation vector, radians squared
  Eigen::Matrix3d translation = Eigen::Matrix3d::Zero();  ///< metres squared

  PairNoise() = default;
  PairNoise(const TruthNoise& noise, const ClockStep& step, const Eigen::Isometry3d& truth);
};

/// Whether the camera moved by so much that the true direction means something: ten of the truth's deviations, which
/// leaves the direction six degrees.
bool hasMoved(double baseline, const TruthNoise& noise);

}  // namespace gms_ransac
