// Noise of the true motion of a data set.
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "datasets/dataset.h"

namespace gms_ransac {

/// Noise of a data set's true motion from image to image, standard deviations for each axis. doc/trust.md has the
/// figures of each kind of set.
struct TruthNoise {
  double rotation = 0;     ///< radians
  double translation = 0;  ///< metres
  double clock = 0;        ///< seconds; constant offset of the images' stamps against those of the truth
  double alignment = 0;    ///< radians; constant rotation of the axes of the truth against those of the camera

  /// True for rendered scenes.
  bool exact() const { return rotation == 0 && translation == 0 && clock == 0 && alignment == 0; }
};

/// The noise for a set, by its name (kitti, tum, freiburg, 7scenes, euroc, rendered), else by its layout.
TruthNoise defaultTruthNoise(const std::string& path);

/// Change of the true motion of a pair by a clock offset of one standard deviation.
struct ClockStep {
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< rotation vector, radians
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< metres
};

/// Zero where the truth is not known around both frames.
ClockStep clockStep(const Dataset& dataset, const DatasetPair& pair, double clock);

/// Covariances of the true motion of one pair (current_in_reference), in the reference frame.
struct PairNoise {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();     ///< of the rotation vector, radians squared
  Eigen::Matrix3d translation = Eigen::Matrix3d::Zero();  ///< metres squared

  PairNoise() = default;
  PairNoise(const TruthNoise& noise, const ClockStep& step, const Eigen::Isometry3d& truth);
};

/// Returns true if the baseline (metres) is ten standard deviations of the truth or more: its direction is then known
/// to six degrees.
bool hasMoved(double baseline, const TruthNoise& noise);

}  // namespace gms_ransac
